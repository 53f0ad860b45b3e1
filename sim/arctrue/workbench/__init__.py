"""The workbench compares a recorded measurement set with a model and names the physical effects
that the model lacks.

Data pass through the packages in this order: ``observations`` adds the conditions (speed,
temperature, time) to each row, ``effects`` calculates the columns of the design matrix, ``noise``
whitens the data and the columns, ``inference`` fits and tests effects, ``compare`` and ``diagnose``
interpret the tests, ``model`` stores the result. The workbench does not import the simulated table;
``arctrue.studies`` imports both.
"""
