"""Tells whether a set has changed a further column there and back, so that another value of this
column would show nothing new."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.part_conditions import column_of
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.column_unit import column_unit

Float = NDArray[np.float64]

THIRD = 1.0 / 3.0
"""Share of the range at each end within which a value counts as low or high: noise of a column
that changes evenly does not cross the middle third."""
LEAST_SWINGS = 3
"""Smallest number of changes between low and high. One change, or one there and back, may coincide
with a change of the machine that no column records."""


def swept_range(column: str, observations: Observations) -> str | None:
    """Return the range of a column, with its unit, if the column swings between low and high values
    in one of the channels; otherwise None."""
    for rows in (observations.reference, observations.capture):
        values = None if rows is None else column_of(rows, column)
        if values is not None and _swings(values) >= LEAST_SWINGS:
            unit = column_unit(column)
            # A name without a unit gives the name in brackets.
            words = "" if unit.startswith("[") else f" {unit}"
            return f"{values.min():.3g} to {values.max():.3g}{words}".replace("-", "−")
    return None


def _swings(values: Float) -> int:
    """Return the number of changes between the lowest and the highest third of the range."""
    low, high = float(values.min()), float(values.max())
    share = (values - low) / max(high - low, 1e-300)
    ends = share[(share < THIRD) | (share > 1.0 - THIRD)] > 0.5
    return int(np.count_nonzero(np.diff(ends)))
