"""Models ``rtl/decoder/glitch_filter.vhd`` bit by bit."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.gateware.latest import latest, value_at


def glitch_filter(
    unfiltered: ArrayLike, filter_length: ArrayLike = 1, reset: ArrayLike = False
) -> NDArray[np.int64]:
    """Return the filtered level of one signal in every clock, shape (clocks + 1,).

    Element t is the output during clock t, 0 in clock 0; the last element is the output after the
    last input. ``unfiltered`` is the level (0 or 1) in each clock, shape (clocks,).
    ``filter_length`` in clocks (0 acts as 1) and ``reset`` are one value per clock, or one for all.
    In a clock with ``reset`` the output takes over the input at once. Raises ValueError if the
    shapes do not fit.
    """
    level, length, loads = np.broadcast_arrays(
        np.atleast_1d(np.asarray(unfiltered, dtype=np.int64)), filter_length, reset
    )
    if level.size == 0:
        return np.zeros(1, dtype=np.int64)
    # A level is accepted once it has lasted long enough. A level that equals the output has no
    # effect when it is accepted, so the present output need not be compared.
    changes = np.diff(level, prepend=level[0]) != 0
    run_start = np.maximum(latest(changes), 0)
    lasted = np.arange(level.size) - run_start + 1
    taken_over = (lasted >= length) | loads.astype(bool)
    return np.concatenate([[0], value_at(latest(taken_over), level, 0)])
