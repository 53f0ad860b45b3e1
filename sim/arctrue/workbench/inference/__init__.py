"""Fits a list of effects to capture and reference together, and tests further effects.

The order of the modules: ``design_matrix``; ``fit`` (with the noise); ``residuals`` and their score
tests; ``search`` for search parameters; ``likelihood_ratio``, with the noise estimated anew without
and with an effect; ``held_out`` rows. Each module works on a ``Solution``, which is frozen.
"""
