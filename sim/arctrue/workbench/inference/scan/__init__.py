"""Scans for the search parameters of an effect that fit the residuals of a model best.

A *place* is a set of values of the search parameters. A scan for orders, frequencies or bumps
processes the rows once: it bins C⁻¹·residual, transforms it by FFT, divides the power by the
information about a wave in this noise, and finds the maxima. A scan for steps uses cumulative sums.
The best places are then scored exactly, with the model projected out; a scan over a grid scores
every point. ``trials`` is the number of independent places.
"""
