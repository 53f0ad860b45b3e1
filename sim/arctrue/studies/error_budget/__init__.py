"""The budget of the calibration: every source simulated alone, their sum, and the whole."""

DRAWS = 100
"""Number of draws. Nearly all noise is in two numbers, cosine and sine of one order: 100 draws
determine its RMS to 5 %."""
