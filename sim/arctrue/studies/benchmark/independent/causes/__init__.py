"""Physical causes of the second generator, one module for each place of action."""
