"""The noise of both channels as a part of the model: white, coloured, uneven, index.

``fit`` estimates it together with a design matrix, channel by channel (``estimate``); ``row_noise``
whitens rows; ``repeats`` gives the scatter of repeats without a model, and ``degrees_of_freedom``
calculates how well the noise of an effect's size is known. The package does not depend on effects
and searches.
"""
