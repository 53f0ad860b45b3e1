"""Contains numerical methods that do not depend on rows, effects or noise."""
