"""Fits a list of effects to capture and reference together, and tests further effects.

The modules in the order of use: ``design_matrix``; ``fit``, with the noise; ``residuals``, with
score tests; ``search`` for search parameters; ``likelihood_ratio``, which estimates the noise anew
without and with an effect; ``held_out``, for omitted rows. Each module uses a ``Solution``, which
is frozen.
"""
