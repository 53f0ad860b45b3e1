"""The noise of both channels as a part of the model: white, coloured, uneven, index."""
