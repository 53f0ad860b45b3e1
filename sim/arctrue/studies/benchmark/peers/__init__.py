"""Simple rival programs, whose scores are compared with those of the diagnosis.

They read the same folders as the diagnosis, and share no code with the workbench.
"""
