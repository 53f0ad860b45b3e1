"""Solves a least-squares problem with more rows than fit into memory at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]


class NormalEquations:
    """Normal equations of a design matrix X: sums XᵀX and Xᵀy block by block."""

    def __init__(self, columns: int) -> None:
        """Start with zero rows."""
        self.matrix: Float = np.zeros((columns, columns))
        self.right: Float = np.zeros(columns)

    def add(self, design: Float, observed: Float) -> None:
        """Add a block of rows of X, ``(rows, columns)``, and of y, ``(rows,)``."""
        self.matrix += design.T @ design
        self.right += design.T @ observed

    def solved(self) -> Float:
        """Return the minimum-norm solution: unknowns that no row determines are 0."""
        norms = np.sqrt(np.diag(self.matrix))
        norms[norms == 0.0] = 1.0
        scaled = self.matrix / np.outer(norms, norms)
        return np.asarray(
            np.linalg.lstsq(scaled, self.right / norms, rcond=LEAST_SINGULAR)[0] / norms
        )


LEAST_SINGULAR = 1e-9
"""A direction counts as undetermined if its eigenvalue of the scaled normal matrix is below this
share of the largest: the rows then determine it over 30,000 times more weakly than the best
direction."""
