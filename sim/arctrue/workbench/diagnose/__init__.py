"""Which physical effect a model lacks, with the statistics that keep the naming honest.

A diagnosis goes one way, a frozen record from stage to stage: ``data_faults`` → ``candidates`` →
``evidence`` (which gives the ``survey``) → ``posterior`` → ``rules`` → ``next_measurement``.
``diagnosis`` calls them in this order. Neighbours use ``diagnosis`` and ``report``.
"""
