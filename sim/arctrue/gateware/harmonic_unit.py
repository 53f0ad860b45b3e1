"""Models the entity ``harmonic_unit``: the terms of equation (9), added in pairs."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.gateware.harmonic_lane import Rotation, lane_cosine
from arctrue.generated.number_formats import (
    AMPLITUDE_FRACTION,
    CORDIC_ITERATIONS,
    COSINE_WIDTH,
    PAIR_FRACTION,
)


def harmonic_unit(
    phases: NDArray[np.int32],
    amplitudes: ArrayLike,
    cosine_width: int = COSINE_WIDTH,
    iterations: int = CORDIC_ITERATIONS,
    rotation: Rotation = "cordic",
) -> NDArray[np.int64]:
    """Return the sums of amplitude · cos(phase) of the lanes 2i and 2i + 1, in 2⁻ᶠ count, F =
    PAIR_FRACTION.

    ``phases``: int32 (angles, lanes), 2⁻²⁴ turn; ``amplitudes``: 2⁻¹¹ count, (lanes,) or, if they
    change with the angle, (angles, lanes). Returns (angles, pairs); if the number of lanes is odd,
    the last pair contains only the last lane. The model omits the latency of the entity.
    """
    cosines = lane_cosine(phases, cosine_width, iterations, rotation)
    factors = np.asarray(amplitudes, dtype=np.int64)
    sums = np.multiply(cosines[:, ::2], factors[..., ::2], dtype=np.int64)
    sums[:, : phases.shape[1] // 2] += np.multiply(
        cosines[:, 1::2], factors[..., 1::2], dtype=np.int64
    )
    cut_off = AMPLITUDE_FRACTION + cosine_width - 2 - PAIR_FRACTION
    if cut_off > 0:
        sums >>= cut_off
    else:
        sums <<= -cut_off
    return sums
