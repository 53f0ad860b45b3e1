"""Contains all rules that find wrong single values of a recording, before any model is fitted.

``single_rows``: rows far from the rows around them, in a capture, at stations, in dense passes.
``reference_rows``: the choice of these rules for a reference run. ``excursions``: values that jump
and come back, such as wrong temperatures. ``masked_row``: a row that is not used, and the reason.
"""
