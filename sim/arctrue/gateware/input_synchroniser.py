"""Models ``rtl/decoder/input_synchroniser.vhd`` bit by bit."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.generated.number_formats import SYNCHRONISER_STAGES_DEFAULT


def input_synchroniser(
    asynchronous: ArrayLike, stages: int = SYNCHRONISER_STAGES_DEFAULT
) -> NDArray[Any]:
    """Return the levels delayed by ``stages`` clocks, with 0 in the first clocks; the first axis is
    the clock.

    The shape is not changed. Raises ValueError for ``stages`` outside 2 to 4.
    """
    if not 2 <= stages <= 4:
        raise ValueError(f"stages is {stages}; expected 2 to 4")
    levels = np.asarray(asynchronous)
    return np.concatenate([np.zeros_like(levels[:1])] * stages + [levels])[: len(levels)]
