"""Simulates hundreds of turns of the virtual instrument, and compares ways to correct the drift of
the orders."""
