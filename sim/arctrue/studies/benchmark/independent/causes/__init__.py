"""Physical causes of the second generator, by where they act."""
