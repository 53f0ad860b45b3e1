"""The fit of a list of effects to capture and reference together."""
