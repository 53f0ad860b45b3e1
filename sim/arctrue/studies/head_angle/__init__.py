"""The choice of the places of two to four heads, of lanes and bits, before a table is built."""
