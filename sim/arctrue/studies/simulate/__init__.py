"""Measurement sets of a table with exact geometry and physical causes, and their truth."""
