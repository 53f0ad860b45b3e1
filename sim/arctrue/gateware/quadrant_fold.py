"""Models the entity ``quadrant_fold``, which folds any phase into the first quadrant."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from arctrue.generated.number_formats import PHASE_WIDTH


class Folded(NamedTuple):
    """Folded phases: cos(phase) equals cos(``folded``) where ``negative`` is 0 and −cos(``folded``)
    where it is −1, apart from an error of 2⁻²⁴ turn in the phase. ``folded``: int32, 2⁻²⁴ turn,
    below a quarter turn; ``negative``: int32."""

    folded: NDArray[np.int32]
    negative: NDArray[np.int32]


def quadrant_fold(phase: NDArray[np.int32]) -> Folded:
    """Return the folded ``phase``, 2⁻²⁴ turn, 0 <= phase < 2²⁴, of any shape; the results have this
    shape."""
    # Each mask is 0 or all ones; it repeats the bit of the half turn or of the quarter turn in
    # every bit.
    half = phase << (32 - PHASE_WIDTH)
    half >>= 31
    quarter = phase << (33 - PHASE_WIDTH)
    quarter >>= 31
    half ^= quarter
    quarter ^= phase
    quarter &= (1 << (PHASE_WIDTH - 2)) - 1
    return Folded(quarter, half)
