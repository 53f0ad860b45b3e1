"""Models the entity ``phase_lane``, which computes n·θ + Φ for one lane of equation (9)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.generated.number_formats import PHASE_STEP_WIDTH, PHASE_WIDTH

_CUT_OFF = PHASE_STEP_WIDTH - PHASE_WIDTH


def phase_lane(
    angle: ArrayLike, phase_step: ArrayLike, phase_offset: ArrayLike
) -> NDArray[np.int32]:
    """Return θ·K + Φ modulo one turn in 2⁻²⁴ turn, rounded half up.

    ``angle``: counts below 2²⁴; ``phase_step``: K in 2⁻⁴⁸ turn per count; ``phase_offset``: Φ in
    2⁻²⁴ turn; all are whole numbers. The shapes of the arguments broadcast; the result has the
    common shape.
    """
    # Products wrap modulo 2⁶⁴. This does not change the 48 low bits, which hold the fraction of a
    # turn.
    turns = np.asarray(angle, dtype=np.uint64) * np.asarray(phase_step, dtype=np.uint64)
    rounding = np.uint64(1 << (_CUT_OFF - 1))
    turns += (np.asarray(phase_offset, dtype=np.uint64) << np.uint64(_CUT_OFF)) + rounding
    turns >>= np.uint64(_CUT_OFF)
    phase = np.asarray(turns).astype(np.int32)
    phase &= (1 << PHASE_WIDTH) - 1
    return phase
