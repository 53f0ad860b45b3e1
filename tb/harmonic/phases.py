"""Makes phases for the tests of the cosine."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.generated.number_formats import PHASE_WIDTH


def phases(count: int, seed: int = 1) -> NDArray[np.int32]:
    """Return ``count`` phases in 2⁻²⁴ turn: near each eighth of a turn, evenly spread, random."""
    turn = 1 << PHASE_WIDTH
    near = np.arange(-40, 41)
    borders = (np.arange(8)[:, None] * (turn // 8) + near).ravel() % turn
    even = np.linspace(0, turn, (count - borders.size) // 2, endpoint=False).astype(np.int64)
    rng = np.random.default_rng(seed)
    some = rng.integers(0, turn, count - borders.size - even.size)
    return np.concatenate([borders, even, some]).astype(np.int32)
