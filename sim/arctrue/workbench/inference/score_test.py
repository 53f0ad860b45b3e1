"""Score test of a block of columns, in the directions that the model does not explain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.workbench.numeric.least_squares import Matrix
from arctrue.workbench.numeric.symmetric import RANK_TOLERANCE

LEAST_OWN_SHARE = 1e-6
"""Smallest share of the weighted squares that the model must leave unexplained in a direction of a
block. A block is the columns of one effect.

A direction with a smaller share belongs to the model, not to the block. Columns are calculated at
measured angles, whose noise of 0.2″ is 10⁻⁶ rad. At 24 faces a wave of order 48.3 differs from a
constant of each face only by that noise times 48.3. Without this limit, the noise of the rows would
appear as a wave of 4,900″. In a wave of the signal period, this noise is multiplied by the number
of lines of the disc (:meth:`Effect.electrical_orders`).
"""


@dataclass(frozen=True)
class Score:
    """The score test of a block of columns against the residuals of a model."""

    gain: float
    """χ² that the block removes from the whitened residuals, with the noise unchanged."""
    rank: int
    coefficients: Matrix
    covariance: Matrix
    moment: Matrix
    information: Matrix
    """Normal matrix of the block, with the model projected out."""
    cross: Matrix
    """Products of the model's columns (terms, run offsets, constant) with the columns of the
    block."""
    own_share: float
    """Share of the weighted sum of squares of the block's columns that the model cannot explain, 0
    to 1."""


def own_directions(
    information: Matrix, projected: Matrix, moment: Matrix, least: float = LEAST_OWN_SHARE
) -> tuple[Matrix, Matrix]:
    """Return ``projected`` and ``moment`` in a block's directions that the model does not explain.

    ``information`` is the normal matrix of the block's columns, shape (k, k), and ``projected`` the
    same matrix with the model projected out. A direction is left out if the ratio of ``projected``
    to ``information`` in it is below ``least``. Directions are tested, not columns: a wave of both
    heads may cancel in R₂ − R₁ and be determined in ε. A block of one column is returned unchanged.
    """
    if moment.size < 2:
        return projected, moment
    diagonal = np.diag(information)
    scale = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    # Columns that differ only by the noise of the angle (multiples of three phases) add no
    # direction.
    same = RANK_TOLERANCE if least <= LEAST_OWN_SHARE else max(least, RANK_TOLERANCE)
    there = values > same * max(float(values[-1]), 1e-300)
    into = vectors[:, there] / np.sqrt(values[there]) / scale[:, np.newaxis]
    shares, turned = np.linalg.eigh(into.T @ projected @ into)
    kept = shares > least
    if kept.all() and there.all():
        return projected, moment
    back = vectors[:, there] * np.sqrt(values[there]) * scale[:, np.newaxis]
    inside = back @ turned[:, kept]
    found = (inside * shares[kept]) @ inside.T
    return found, inside @ (turned[:, kept].T @ (into.T @ moment))


def above_the_phase_noise(
    projected: Matrix, moment: Matrix, noise: Matrix
) -> tuple[Matrix, Matrix]:
    """Return ``projected`` and ``moment`` in the directions whose squares exceed those of phase
    noise.

    ``noise``: squares that the noise of the readings gives each column, shape (columns,). If the
    rows have few different signal phases, the model explains most of a wave, and the part that it
    leaves may be small. The share alone does not show whether this part is only noise of the phase.
    """
    scale = np.sqrt(np.maximum(noise, 1e-300))
    values, vectors = np.linalg.eigh(projected / np.outer(scale, scale))
    kept = values > 1.0
    if kept.all():
        return projected, moment
    inside = vectors[:, kept]
    found = (inside * values[kept]) @ inside.T * np.outer(scale, scale)
    return found, scale * (inside @ (inside.T @ (moment / scale)))
