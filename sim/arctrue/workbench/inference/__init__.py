"""Fits a list of effects to capture and reference together, and tests further effects.

The modules in the order of use are ``design_matrix``; ``fit``, which also estimates the noise;
``residuals`` with score tests; ``search`` for search parameters; ``likelihood_ratio``, which
estimates the noise both without and with an effect; and ``held_out`` for omitted rows. No module
changes a ``Solution``.
"""
