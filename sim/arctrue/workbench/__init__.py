"""The workbench compares a recorded measurement set with a model and names what the model lacks.

Data pass through the packages in this order: ``observations`` adds the conditions to each row,
``effects`` calculates the columns of the design matrix, ``noise`` whitens both, ``inference`` fits
and tests, ``compare`` and ``diagnose`` interpret the tests, ``model`` stores the result. The
workbench does not import the simulated table; the studies import both.
"""
