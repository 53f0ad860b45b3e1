"""ArcTrue: the true angle of a rotary table from two read heads."""
