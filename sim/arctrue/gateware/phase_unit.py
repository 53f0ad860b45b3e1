"""Models the entity ``phase_unit``, which computes the phases of all lanes."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.gateware.phase_lane import phase_lane


def phase_unit(
    angle: ArrayLike, phase_steps: ArrayLike, phase_offsets: ArrayLike
) -> NDArray[np.int32]:
    """Return the phases in 2⁻²⁴ turn, (angles, lanes); the model omits the latency of the entity.

    ``angle``: counts, 0 <= angle < 2²⁴, (angles,). ``phase_steps``: K in 2⁻⁴⁸ turn per count and
    ``phase_offsets``: Φ in 2⁻²⁴ turn, (lanes,) or, if they change with the angle, (angles, lanes).
    """
    return phase_lane(np.asarray(angle)[:, np.newaxis], phase_steps, phase_offsets)
