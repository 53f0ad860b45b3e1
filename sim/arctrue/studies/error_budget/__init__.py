"""Budget of the calibration's uncertainty: each source simulated alone, their sum, and all sources
together."""

DRAWS = 100
"""Number of draws. Two numbers, cosine and sine of one order, contain nearly all noise: 100 draws
determine its RMS to 5 %."""
