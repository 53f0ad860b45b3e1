"""Checks, on the rows of a set, whether the columns of a user's effect agree with its
declarations."""
