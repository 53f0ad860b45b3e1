"""Least squares over more rows than fit into memory at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]


class NormalEquations:
    """XᵀX and Xᵀy of a design matrix X, summed block by block."""

    def __init__(self, columns: int) -> None:
        """Begin without rows."""
        self.matrix: Float = np.zeros((columns, columns))
        self.right: Float = np.zeros(columns)

    def add(self, design: Float, observed: Float) -> None:
        """Add a block of rows, ``(rows, columns)`` and ``(rows,)``."""
        self.matrix += design.T @ design
        self.right += design.T @ observed

    def solved(self) -> Float:
        """Give the minimum-norm solution: unknowns that no row determines are 0."""
        norms = np.sqrt(np.diag(self.matrix))
        norms[norms == 0.0] = 1.0
        scaled = self.matrix / np.outer(norms, norms)
        return np.asarray(
            np.linalg.lstsq(scaled, self.right / norms, rcond=LEAST_SINGULAR)[0] / norms
        )


LEAST_SINGULAR = 1e-9
"""Least eigenvalue of the scaled normal matrix: smaller ones belong to undetermined directions,
30,000 times weaker than the strongest."""
