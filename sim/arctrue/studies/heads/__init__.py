"""Shows on turns after the calibration which errors the mean of four heads corrects, but two heads
do not."""
