"""Which physical effect a model lacks, with the statistics that keep the naming honest.

A diagnosis is a sequence of stages, each of which gives a frozen record to the next:
``data_faults`` → ``candidates`` → ``evidence`` (which gives the ``survey``) → ``posterior`` →
``rules`` → ``next_measurement``. ``diagnosis`` calls them in this order. Other packages use
``diagnosis`` and ``report``.
"""
