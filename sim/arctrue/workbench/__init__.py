"""The workbench compares a recorded measurement set with a model and names what the model lacks.

A row of a set goes one way: ``observations`` gives it its conditions, ``effects`` gives the design
matrix its columns, ``noise`` whitens it, ``inference`` fits and tests, ``compare`` and ``diagnose``
say what the tests mean, ``model`` keeps the result. The simulated table is not imported; studies
use both.
"""
