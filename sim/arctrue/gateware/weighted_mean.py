"""Models the entity ``weighted_mean``, which computes the term that the mean adds to the
correction."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.gateware.mean_set import MeanSet
from arctrue.gateware.turn_difference import turn_difference
from arctrue.generated.number_formats import (
    HEAD_DIFFERENCE_WIDTH,
    HEAD_OFFSET_FRACTION,
    MEAN_TERM_FRACTION,
)

TERM_LSB_COUNTS = 2.0**-MEAN_TERM_FRACTION
"""Value of the last bit of a word of the mean's term, counts."""
_LIMIT = 1 << (HEAD_DIFFERENCE_WIDTH - 1)


class MeanTerm(NamedTuple):
    """Outputs of the entity for the readings of each clock, (clocks,)."""

    term: NDArray[np.int64]
    """Term of the mean, f_s − Σ wᵢ·(rᵢ − r_s), in 2⁻²⁰ count; f_s is the fraction of the carrier's
    offset, and :class:`MeanSet` defines the other symbols."""
    limited: NDArray[np.bool_]
    """Whether the difference of a used head did not fit its format."""


def whole_readings(angles: ArrayLike, mean: MeanSet, counts_per_rev: int) -> NDArray[np.int64]:
    """Return Rᵢ minus the whole counts of oᵢ, within one turn, as (clocks, heads) counts."""
    whole = np.array(mean.offsets, dtype=np.int64) >> HEAD_OFFSET_FRACTION
    readings: NDArray[np.int64] = (np.asarray(angles, dtype=np.int64) - whole) % counts_per_rev
    return readings


def weighted_mean(readings: ArrayLike, mean: MeanSet, counts_per_rev: int) -> MeanTerm:
    """Return the mean's term for ``readings``, the whole counts that :func:`whole_readings`
    returns."""
    whole = np.asarray(readings, dtype=np.int64)
    carrier = mean.carrier - 1
    fractions = np.array(mean.offsets, dtype=np.int64) % (1 << HEAD_OFFSET_FRACTION)
    differences = turn_difference(whole, whole[:, carrier, np.newaxis], counts_per_rev)
    fine = (differences << HEAD_OFFSET_FRACTION) + fractions[carrier] - fractions
    kept = np.clip(fine, -_LIMIT, _LIMIT - 1)
    products = kept * np.array(mean.weights, dtype=np.int64)
    fraction = int(fractions[carrier]) << (MEAN_TERM_FRACTION - HEAD_OFFSET_FRACTION)
    return MeanTerm(fraction - products.sum(axis=1), ((kept != fine) & mean.used).any(axis=1))
