"""Splits rows into runs: stretches of consecutive rows with the same label."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray


def run_spans(run: NDArray[Any]) -> list[tuple[int, int]]:
    """Return first and end row (exclusive) of each stretch of equal labels; ``run``: (rows,)."""
    if run.size == 0:
        return []
    edges = np.flatnonzero(run[1:] != run[:-1]) + 1
    return list(pairwise([0, *edges.tolist(), run.size]))
