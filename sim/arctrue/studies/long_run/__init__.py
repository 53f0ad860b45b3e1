"""Hundreds of turns on the virtual instrument: drift of the orders, and ways to correct it."""
