"""Chooses the places of two to four heads, the lanes and the bits, before a table is built."""
