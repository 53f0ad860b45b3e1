"""Compares a model with a set: maps residuals against every condition, and ranks the conditions."""
