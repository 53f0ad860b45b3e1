"""Least squares over more rows than fit into memory at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]


class NormalEquations:
    """XᵀX and Xᵀy, added up block by block."""

    def __init__(self, columns: int) -> None:
        """No rows yet."""
        self.matrix: Float = np.zeros((columns, columns))
        self.right: Float = np.zeros(columns)

    def add(self, design: Float, observed: Float) -> None:
        """A block of rows, ``(rows, columns)`` and ``(rows,)``."""
        self.matrix += design.T @ design
        self.right += design.T @ observed

    def solved(self) -> Float:
        """The shortest solution: what no row tells is 0."""
        norms = np.sqrt(np.diag(self.matrix))
        norms[norms == 0.0] = 1.0
        scaled = self.matrix / np.outer(norms, norms)
        return np.asarray(
            np.linalg.lstsq(scaled, self.right / norms, rcond=LEAST_SINGULAR)[0] / norms
        )


LEAST_SINGULAR = 1e-9
"""Of the scaled normal matrix: what is seen 30,000 times less well than the rest is not seen."""
