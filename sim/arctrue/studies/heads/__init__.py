"""Shows on fresh turns which errors the mean of four heads corrects and two heads do not."""
