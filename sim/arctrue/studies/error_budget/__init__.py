"""The budget of the calibration: every source simulated alone, their sum, and the whole."""
