"""Chooses the places of two to four heads and the number of lanes and bits before a table is
built."""
