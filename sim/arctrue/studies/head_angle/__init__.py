"""The choice of the angle α between two heads, and of lanes and bits, before a table is built."""
