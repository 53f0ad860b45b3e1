"""Hundreds of turns on the virtual instrument: how far the orders wander, and what holds them."""
