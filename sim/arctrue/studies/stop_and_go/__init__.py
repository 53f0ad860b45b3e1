"""Repeats the paper's ten cycles with stops: a servo moves the table to each face and stops it
there."""
