"""Fits a list of effects to capture and reference together, and tests further effects.

``design_matrix`` → ``fit`` (with the noise) → ``residuals`` and their score tests → ``search`` for
places, ``likelihood_ratio`` with the noise estimated anew on both sides, ``held_out`` rows. Each
module works on a ``Solution``, which is frozen.
"""
