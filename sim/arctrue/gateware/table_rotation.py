"""Models the entity ``table_rotation``: the cosine from a table of straight lines."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.generated.number_formats import (
    COSINE_ADDRESS_WIDTH,
    COSINE_ROWS,
    COSINE_SLOPE_FRACTION,
    COSINE_VALUE_FRACTION,
    COSINE_WIDTH,
    PHASE_WIDTH,
)

FOLDED_WIDTH = PHASE_WIDTH - 2
OFFSET_WIDTH = FOLDED_WIDTH - COSINE_ADDRESS_WIDTH
DIGITS_WIDTH = 2 * COSINE_ROWS
ROW_FRACTION = (
    COSINE_SLOPE_FRACTION + PHASE_WIDTH - OFFSET_WIDTH + DIGITS_WIDTH - 2 * (COSINE_ROWS - 1)
)
"""Number of fraction bits of the last row of adders; every row except the first drops two bits."""


@dataclass(frozen=True, eq=False)
class TangentTable:
    """Table that is computed when the entity is elaborated; both arrays are int32, (128,).

    ``slopes``: −dcos/dturn of the intervals in 2⁻⁸ per turn; ``values``: the value of each line at
    the start of its interval, 2⁻²⁰.
    """

    slopes: NDArray[np.int32]
    values: NDArray[np.int32]


@functools.cache
def tangent_table() -> TangentTable:
    """Compute the lines (1 − h²/4)·cos m − sin m·z of 128 intervals with middle m and half width h;
    z is the distance from the middle, radians."""
    intervals = 1 << COSINE_ADDRESS_WIDTH
    middles = (np.arange(intervals) + 0.5) * (np.pi / 2) / intervals
    slopes = np.floor(2 * np.pi * np.sin(middles) * 2.0**COSINE_SLOPE_FRACTION + 0.5)
    reach_turn = 2.0 ** (OFFSET_WIDTH - 1 - PHASE_WIDTH)
    half_unit_turn = 2.0 ** (OFFSET_WIDTH - DIGITS_WIDTH - 1 - PHASE_WIDTH)
    scale = 1 - (2 * np.pi * reach_turn) ** 2 / 4
    slopes_per_turn = slopes / 2.0**COSINE_SLOPE_FRACTION
    values = scale * np.cos(middles) + slopes_per_turn * (reach_turn - half_unit_turn)
    values -= 2.0 ** (-ROW_FRACTION - 1)
    rounded = np.floor(values * 2.0**COSINE_VALUE_FRACTION + 0.5)
    return TangentTable(slopes.astype(np.int32), rounded.astype(np.int32))


def error_bound() -> float:
    """Return a bound of the error of a lane's cosine for an amplitude of 1: the sum of the errors
    that the entity's header lists.

    The errors come from the line in place of the cosine, the angle in place of its sine, the
    rounding of the slope, the omitted bits of the angle, the rounding of the value, the truncation
    in the rows of adders, the folding of the phase and the rounding to s1.16.
    """
    half_width = 2 * np.pi * 2.0 ** (OFFSET_WIDTH - 1 - PHASE_WIDTH)
    return float(
        half_width**2 / 4
        + half_width**3 / 6
        + 2.0 ** (-COSINE_SLOPE_FRACTION - 1) * 2.0 ** (OFFSET_WIDTH - 1 - PHASE_WIDTH)
        + 2 * np.pi * 2.0 ** (OFFSET_WIDTH - DIGITS_WIDTH - 1 - PHASE_WIDTH)
        + 2.0 ** (-COSINE_VALUE_FRACTION - 1)
        + 2.0 ** (-ROW_FRACTION - 1)
        + 2 * np.pi * 2.0**-PHASE_WIDTH
        + 2.0 ** -(COSINE_WIDTH - 1)
    )


def table_rotation(folded: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the cosine in 2⁻¹⁸, with two bits more than the lane's cosine.

    ``folded``: int32, 2⁻²⁴ turn, below a quarter turn, of any shape; the result has the same shape.
    """
    table = tangent_table()
    address = folded >> OFFSET_WIDTH
    digits = (folded >> (OFFSET_WIDTH - DIGITS_WIDTH)) & ((1 << DIGITS_WIDTH) - 1)
    slope = table.slopes.take(address)
    row = np.zeros_like(folded)
    for place in range(COSINE_ROWS):
        row >>= 2
        row += ((digits >> (2 * place)) & 3) * slope
    value = table.values.take(address) - (row << (COSINE_VALUE_FRACTION - ROW_FRACTION))
    cosine: NDArray[np.int32] = value >> (COSINE_VALUE_FRACTION - COSINE_WIDTH)
    return cosine
