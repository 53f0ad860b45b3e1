"""Calculates canonical correlations of the columns of two effects, with the model projected out of
both."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Columns, Effect, FitContext, Nonlinear
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows

Float = NDArray[np.float64]

LEAST_EIGENVALUE = 1e-6
"""Smallest eigenvalue of a direction that is used, as a share of the largest eigenvalue. The model
explains directions with smaller eigenvalues, except for rounding."""


class _SideBySide(Effect):
    """The columns of several effects as one block."""

    name = "side_by_side"

    def __init__(self, terms: Sequence[Term], observations: Observations) -> None:
        super().__init__()
        self.terms = terms
        self.widths = [len(term.effect.column_names(observations)) for term in terms]

    def column_names(self, observations: Observations) -> list[str]:
        """Return the names of the columns of all effects, in the order of the effects."""
        return [name for term in self.terms for name in term.effect.column_names(observations)]

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        """Return the columns of all effects side by side; None if no effect has columns in the
        capture."""
        return self._joined(
            [term.effect.capture_columns(rows, term.nonlinear, context) for term in self.terms],
            rows.run.size,
        )

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        """Return the columns of all effects side by side; None if no effect has columns in the
        reference."""
        return self._joined(
            [term.effect.reference_columns(rows, term.nonlinear, context) for term in self.terms],
            rows.run.size,
        )

    def _joined(self, blocks: Sequence[Columns | None], rows: int) -> Columns | None:
        if all(block is None for block in blocks):
            return None
        return np.hstack(
            [
                np.zeros((rows, width)) if block is None else block
                for block, width in zip(blocks, self.widths, strict=True)
            ]
        )


def canonical_correlations(residuals: Residuals, first: Term, second: Term) -> Float:
    """Return the canonical correlations of two whitened blocks, with the model projected out.

    The correlations are in descending order, and their number is the smaller of the two ranks. If
    the last correlation is near 1, the block of smaller rank lies within the other block; if only
    the first correlation is near 1, the blocks share one direction.
    """
    joint = _SideBySide([first, second], residuals.observations)
    score = residuals.score(joint, {})
    # Columns that the model explains up to rounding have no covariance.
    alive = np.diag(score.covariance) > 0.0
    information = np.where(alive[:, None] & alive[None, :], score.information, 0.0)
    width = joint.widths[0]
    own, other = information[:width, :width], information[width:, width:]
    left, right = _whitening(own), _whitening(other)
    if left.shape[1] == 0 or right.shape[1] == 0:
        return np.zeros(0)
    values = np.linalg.svd(left.T @ information[:width, width:] @ right, compute_uv=False)
    return np.asarray(np.minimum(values, 1.0))


def _whitening(information: Float) -> Float:
    """Return W such that WᵀIW is the identity matrix; W has one column for each direction that the
    information matrix I determines."""
    diagonal = np.diag(information)
    scale = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    kept = values > LEAST_EIGENVALUE * max(float(values[-1]), 1e-300)
    return np.asarray(vectors[:, kept] / np.sqrt(values[kept]) / scale[:, np.newaxis])
