"""Finds the line of the file that contains a row."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def file_line(used: NDArray[np.int64] | None, row: int) -> int:
    """Return the line of the file that contains a row.

    Parameters
    ----------
    used : ndarray or None
        Numbers in the file (0, 1, …) of the rows that are used; None if all rows are used.
    row : int
        Number of the row among the rows that are used, from 0.

    Returns
    -------
    int
        Number of the line; the header is line 1.
    """
    return (row if used is None else int(used[row])) + 2
