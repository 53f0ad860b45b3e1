"""The noise of both channels as a part of the model: white, coloured, uneven, index.

``fit`` estimates it beside a design matrix, channel by channel (``estimate``); ``row_noise``
whitens rows; ``repeats`` is the scatter of repeats without a model, ``degrees_of_freedom`` how well
the noise of an effect's size is known. Effects and searches are not known here.
"""
