"""Simulates measurement sets of a table with exact geometry and physical causes, and writes their
truth."""
