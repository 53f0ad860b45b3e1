"""Hundreds of turns of the virtual instrument: how the orders drift, and ways to correct the
drift."""
