"""Estimates the noise of both channels as a part of the model: white and coloured parts, uneven
scatter, index.

``fit`` estimates the noise together with a design matrix, channel by channel (``estimate``);
``row_noise`` whitens rows; ``repeats`` calculates the scatter of repeats without a model, and
``degrees_of_freedom`` the degrees of freedom of the noise in an effect's size. The package does not
depend on effects and searches.
"""
