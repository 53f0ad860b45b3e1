"""Solves symmetric positive semidefinite systems, with their rank."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]

RANK_TOLERANCE = 1e-9
"""An eigenvalue of the scaled normal matrix counts as zero if it is at most this share of the
largest eigenvalue. In double precision, rounding causes eigenvalues of about 1e-16 times the number
of rows.
"""
UNSEEN = 1e-18
"""A column counts as rounding, not as data, if its sum of squares is at most this share of the
largest column's sum of squares."""


def solve_symmetric(normal: Matrix, moment: Matrix) -> tuple[Matrix, Matrix, int, float]:
    """Solve a normal system; return solution, covariance, rank and condition number.

    The system is scaled to a diagonal of 1 first. In directions that the data do not determine, the
    solution is the shortest one in the scaled unknowns.
    """
    diagonal = np.diag(normal)
    seen = diagonal > UNSEEN * max(float(diagonal.max(initial=0.0)), 1e-300)
    # A column that would be zero without rounding (order 120 at 33°) must not be scaled up to 1.
    scale = np.where(seen, np.sqrt(np.where(seen, diagonal, 1.0)), 1e150)
    values, vectors = np.linalg.eigh(normal / np.outer(scale, scale))
    kept = values > RANK_TOLERANCE * max(float(values[-1]), 1e-300)
    inverse = (vectors[:, kept] / values[kept]) @ vectors[:, kept].T / np.outer(scale, scale)
    condition = float(values[-1] / values[kept][0]) if kept.any() else float("inf")
    return inverse @ moment, inverse, int(kept.sum()), condition


def log_determinant(normal: Matrix) -> float:
    """Return the log determinant of a normal matrix over the directions that the data determine.

    The result is the logarithm of the product of the eigenvalues above 0. Let D be the diagonal of
    N, Λ the eigenvalues above 0 of D^−½·N·D^−½, and V₀ its eigenvectors to the eigenvalue 0. Then
    that product is |Λ|·|D|·|V₀ᵀ·D⁻¹·V₀|.
    """
    diagonal = np.diag(normal)
    seen = diagonal > UNSEEN * float(diagonal.max(initial=1e-300))
    root = np.sqrt(diagonal[seen])
    values, vectors = np.linalg.eigh(normal[np.ix_(seen, seen)] / np.outer(root, root))
    kept = values > RANK_TOLERANCE * max(float(values.max(initial=0.0)), 1e-300)
    upper = np.linalg.qr(vectors[:, ~kept] / root[:, np.newaxis], mode="r")
    halves = float(np.sum(np.log(root)) + np.sum(np.log(np.abs(np.diag(upper)))))
    return float(np.sum(np.log(values[kept]))) + 2.0 * halves
