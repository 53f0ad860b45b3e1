"""What the calibrated mean of four heads shows that two heads cannot: fresh turns, no fit."""
