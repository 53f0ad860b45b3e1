"""Rules that decide the verdict: one table, and the functions of its lines by subject."""
