"""Numerical means that know nothing of rows, effects or noise."""
