"""Chooses the places of two to four heads, the number of lanes and of bits, before a table is
built."""
