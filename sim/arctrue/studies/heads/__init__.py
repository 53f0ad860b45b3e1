"""Shows on fresh turns, without a fit, what the calibrated mean of four heads corrects and two
heads cannot."""
