"""Does a user's effect do what its file says? Its columns are held against a set of rows."""
