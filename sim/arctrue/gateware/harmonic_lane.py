"""Models the entity ``harmonic_lane``: amplitude · cos(phase) of equation (9)."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.gateware.cordic_rotation import cordic_rotation
from arctrue.gateware.quadrant_fold import quadrant_fold
from arctrue.gateware.table_rotation import table_rotation
from arctrue.generated.number_formats import CORDIC_ITERATIONS, COSINE_WIDTH, GUARD_WIDTH

Rotation = Literal["cordic", "table"]
"""Values of the generic ROTATION, which selects how the cosine is computed."""

# Number of phases that are processed at a time; their arrays then fit the processor's cache.
_BLOCK = 16384


def lane_cosine(
    phase: NDArray[np.int32],
    cosine_width: int = COSINE_WIDTH,
    iterations: int = CORDIC_ITERATIONS,
    rotation: Rotation = "cordic",
) -> NDArray[np.int32]:
    """Return the cosine in the format of the multiplier's input: sign, integer bit,
    ``cosine_width`` − 2 fraction bits.

    ``phase``: int32, 2⁻²⁴ turn, 0 <= phase < 2²⁴, of any shape; the result has the same shape.
    Raises ValueError for a width or a number of iterations that the entity does not support.
    """
    if rotation == "table" and (cosine_width, iterations) != (COSINE_WIDTH, CORDIC_ITERATIONS):
        raise ValueError(
            f"cosine of {cosine_width} bits with {iterations} iterations: ROTATION = table is "
            f"built for {COSINE_WIDTH} bits and {CORDIC_ITERATIONS} iterations only"
        )
    flat = phase.reshape(-1)
    cosine = np.empty(flat.shape, dtype=np.int32)
    for start in range(0, flat.size, _BLOCK):
        block = slice(start, start + _BLOCK)
        folded, negative = quadrant_fold(flat[block])
        if rotation == "table":
            rotated = table_rotation(folded)
        else:
            rotated = cordic_rotation(folded, cosine_width, iterations)
        # The complement before the rounding gives exactly the negative of the rounded value.
        rotated ^= negative
        rotated += 1 << (GUARD_WIDTH - 1)
        np.right_shift(rotated, GUARD_WIDTH, out=cosine[block])
    return cosine.reshape(phase.shape)


def harmonic_lane(
    phase: NDArray[np.int32],
    amplitude: ArrayLike,
    cosine_width: int = COSINE_WIDTH,
    iterations: int = CORDIC_ITERATIONS,
    partner: ArrayLike = 0,
    rotation: Rotation = "cordic",
) -> NDArray[np.int64]:
    """Return amplitude · cos(phase) + ``partner`` in 2⁻ᶠ count, f = ``cosine_width`` + 9 (27).

    ``phase``: int32, 2⁻²⁴ turn; ``amplitude``: 2⁻¹¹ count; ``partner``: product of the other lane
    of the pair, 2⁻ᶠ count. The shapes of the arguments broadcast.
    """
    cosine = lane_cosine(phase, cosine_width, iterations, rotation).astype(np.int64)
    product: NDArray[np.int64] = cosine * np.asarray(amplitude, dtype=np.int64)
    return product + np.asarray(partner, dtype=np.int64)
