"""Models the entity ``delay_line``, which delays words by whole clocks."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from arctrue.generated.number_formats import DELAY_LINE_LATENCY

Word = TypeVar("Word", bound=np.generic)


def delay_line(undelayed: NDArray[Word], clocks: int = DELAY_LINE_LATENCY) -> NDArray[Word]:
    """Return the words delayed by ``clocks`` clocks; the first ``clocks`` outputs are 0.

    The shape of input and output is (number of clocks in the run, …).

    Raises ValueError for a delay below one clock.
    """
    if clocks < 1:
        raise ValueError(f"clocks: {clocks}, a delay line has at least 1")
    delayed = np.zeros_like(undelayed)
    delayed[clocks:] = undelayed[: len(undelayed) - clocks] if clocks < len(undelayed) else 0
    return delayed
