"""Simple rivals of the diagnosis, so that its figures have something to stand beside.

They read the same folders, and share no code with the workbench.
"""
