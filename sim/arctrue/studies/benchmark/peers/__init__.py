"""Contains simple rival programs; the benchmark compares their scores with the score of the
diagnosis.

The rivals read the same folders as the diagnosis and share no code with the workbench.
"""
