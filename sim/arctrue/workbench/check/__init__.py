"""Check whether a user's effect agrees with its declarations: compare its columns with a set of
rows."""
