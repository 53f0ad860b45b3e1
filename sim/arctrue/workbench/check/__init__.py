"""Check whether a user's effect does what its file says: compare its columns with a set of rows."""
