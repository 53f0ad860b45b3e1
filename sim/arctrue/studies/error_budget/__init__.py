"""Budget of the calibration's uncertainty: every source simulated alone, their sum, and all
together."""

DRAWS = 100
"""Number of draws. Nearly all noise is in two numbers, cosine and sine of one order: 100 draws
determine its RMS to 5 %."""
