"""Contains small helpers that every package may use: units, texts, whole files, typed content."""
