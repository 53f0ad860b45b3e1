"""Finds the physical effect that a model lacks, with statistical tests that prevent wrong names.

A diagnosis is a sequence of stages, each of which gives a frozen record to the next:
``data_faults`` → ``candidates`` → ``evidence`` (which gives the ``survey``) → ``posterior`` →
``rules`` → ``next_measurement``. ``diagnosis`` calls them in this order. Other packages use
``diagnosis`` and ``report``.
"""
