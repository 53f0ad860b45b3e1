"""Estimates the noise of both channels as a part of the model: white and coloured parts, uneven
scatter, and the scatter of the index.

``fit`` estimates the noise together with a design matrix, channel by channel (``estimate``);
``row_noise`` whitens rows; ``repeats`` calculates the scatter of repeats without a model;
``degrees_of_freedom`` calculates the degrees of freedom with which the noise in an effect's size is
known. The package imports neither effects nor searches.
"""
