"""The fit of a list of effects to capture and reference together, and what further columns add.

``design_matrix`` → ``fit`` (with the noise) → ``residuals`` and their score tests → ``search`` for
places, ``likelihood_ratio`` with the noise free on both sides, ``held_out`` rows. Each works on a
``Solution``, which is frozen.
"""
