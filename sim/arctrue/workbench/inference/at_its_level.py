"""Tests an effect of the reference in noise whose level changes with time, such as gusts of wind.

The estimated noise has one level. Where a gust begins, the slow part of the noise jumps too. A few
rows there then determine the size of an effect that does not exist. Here the uncertainty of the
size follows from the scatter of the rows that determine it (the estimate of White, Econometrica 48
(1980) 817, for rows of unequal variance).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arctrue.workbench.effects.base import Effect, Nonlinear
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.score_test import Score
from arctrue.workbench.noise.level import noise_level
from arctrue.workbench.numeric.least_squares import Matrix
from arctrue.workbench.numeric.symmetric import solve_symmetric

LEAST_FREE = 0.01
"""Smallest share of a row that the columns leave free; it only prevents a division by zero."""


@dataclass(frozen=True)
class AtItsLevel:
    """The gain of an effect in noise of changing level."""

    gain: float
    """Twice the rise of the log likelihood that has the same p in white noise."""
    freedom: float
    """Effective number of rows that determine the size of the effect."""


def gains_at_its_level(
    base: Residuals, effect: Effect, nonlinear: Nonlinear, score: Score, *, takes_most: bool
) -> list[AtItsLevel]:
    """Return the gains of an effect with the whitened rows, and with these rows divided by their
    local RMS; an empty list if the level does not change or the effect changes the capture.

    The local RMS is that of the residuals with the effect in the model, so that the effect is not
    taken for a change of the level. The residuals with the effect are smallest in the rows that
    determine it, which are often the loud rows. Each residual is therefore divided by the share of
    its row that the columns leave free (MacKinnon and White, J. Econometrics 29 (1985) 305). If few
    rows determine the effect, it may still contain their noise. Unless the effect removes most of
    the error (``takes_most``), the residuals without the effect are therefore used as well; they
    can only understate the gain.
    """
    left, rows = base.reference_whitened, base.reference_design
    capture, own = base.whitened_columns(effect, nonlinear)
    if left is None or rows is None or own is None or (capture is not None and capture.any()):
        return []
    projected = base.projected_columns(effect, nonlinear, score)[1]
    assert projected is not None
    level = noise_level(left - projected @ score.coefficients)
    if level is None:
        return []
    found = []
    for local in (np.ones(left.size), level.local):
        # A held model keeps its coefficients, but the constant of the reference is always fitted.
        model = rows.ones[:, np.newaxis] if base.solution.held else rows.every_column
        model = model / local[:, np.newaxis]
        values = np.column_stack([left, own]) / local[:, np.newaxis]
        values = values - model @ np.linalg.lstsq(model, values, rcond=1e-10)[0]
        found.append(_gain(values[:, 0], values[:, 1:], with_effect=True))
        if not takes_most:
            found.append(_gain(values[:, 0], values[:, 1:], with_effect=False))
    return found


def _gain(values: Matrix, columns: Matrix, *, with_effect: bool) -> AtItsLevel:
    """Return the gain by which ``columns``, shape (rows, k), explain ``values``.

    ``with_effect``: the scatter of a row is its residual with the columns in the model.
    """
    moment = columns.T @ values
    coefficients, inverse, _, _ = solve_symmetric(columns.T @ columns, moment)
    leverage = np.einsum("ij,jk,ik->i", columns, inverse, columns)
    scatter = values
    if with_effect:
        scatter = (values - columns @ coefficients) / np.maximum(1.0 - leverage, LEAST_FREE)
    weighted = columns * scatter[:, np.newaxis]
    shifts, _, rank, _ = solve_symmetric(weighted.T @ weighted, moment)
    # The variance of the size is a sum over the rows: its degrees of freedom follow Satterthwaite.
    # The fourth power of a normal value has the mean 3σ⁴, so that this ratio has the mean
    # (n + 2)/3 for n rows of equal weight.
    of_rows = leverage * scatter**2
    ratio_of_squares = float(np.sum(of_rows)) ** 2 / max(float(np.sum(of_rows**2)), 1e-300)
    freedom = max(3.0 * ratio_of_squares - 2.0, 1.0)
    ratio = max(float(moment @ shifts), 0.0) / max(rank, 1)
    return AtItsLevel(float((freedom + rank) * np.log1p(rank * ratio / freedom)), freedom)
