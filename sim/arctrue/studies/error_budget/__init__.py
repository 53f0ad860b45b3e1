"""Computes the uncertainty budget of the calibration: simulates each source of error alone and all
sources together, and compares the sum of the single errors with the error of all sources together.
"""

DRAWS = 100
"""Default number of draws. Cosine and sine of one order (11) contain nearly all the noise, so 100
draws, with two values each, determine its RMS to 5 %."""
