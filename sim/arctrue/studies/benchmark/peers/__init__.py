"""Simple rivals of the diagnosis, for comparison with its figures.

They read the same folders, and share no code with the workbench.
"""
