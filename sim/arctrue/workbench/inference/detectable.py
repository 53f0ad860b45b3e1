"""The smallest size of an effect that a set would show."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import chdtri, chndtr

from arctrue.workbench.effects.base import Effect, Nonlinear, Parameter
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.solution import Solution

Float = NDArray[np.float64]

SIGNIFICANCE = 0.01
POWER = 0.95
MOST_ROWS = 20_000
"""The mean square of a column does not need more."""
PROPORTIONAL = 1e-6
"""A parameter is a size when it doubles with the coefficients to within this."""


@dataclass(frozen=True)
class Detectable:
    """A typical form of an effect at the size at which it is found."""

    rms_arcsec: dict[str, float]
    """By channel, over its rows."""
    size: Parameter | None
    """In the effect's own unit; None where no parameter of it is a size."""


def needed_gain(rank: int, tests: float) -> float:
    """Noncentrality at which a block of ``rank`` columns is found with 95 % power.

    At 1 %, divided among ``tests``: candidates times the places that each looks at.
    """
    threshold = float(chdtri(rank, SIGNIFICANCE / max(tests, 1.0)))
    return float(
        brentq(
            lambda gain: 1.0 - POWER - chndtr(threshold, rank, gain), 1e-6, 4.0 * threshold + 100.0
        )
    )


def smallest_detectable(
    residuals: Residuals, effect: Effect, nonlinear: Nonlinear, tests: float
) -> Detectable | None:
    """Smallest form of an effect that is found in 95 % of such sets, beside the model.

    Of all forms that the block can take, the typical one: the median of its columns. None where
    the model can stand in for all of it.
    """
    score = residuals.score(effect, nonlinear)
    if score.rank == 0:
        return None
    gain = needed_gain(score.rank, tests)
    information = np.diag(score.information)
    there = information > 0.0
    # A column that others of its block, or the model, take whole is not seen by itself.
    sizes = np.where(there, np.sqrt(gain / np.maximum(information, 1e-300)), 0.0)
    shown: dict[str, float] = {}
    typical = int(np.flatnonzero(there)[0])
    for channel, columns in _columns(effect, nonlinear, residuals.solution):
        moved = sizes * np.sqrt(np.mean(columns**2, axis=0))
        if float(np.max(moved[there], initial=0.0)) > 0.0:
            shown[channel] = float(np.median(moved[there]))
            nearest = np.where(there, np.abs(moved - shown[channel]), np.inf)
            typical = int(np.argmin(nearest))
    return Detectable(shown, _size(effect, nonlinear, sizes, typical, residuals))


def _size(
    effect: Effect, nonlinear: Nonlinear, sizes: Float, column: int, residuals: Residuals
) -> Parameter | None:
    """The first parameter that doubles when the coefficients do."""
    coefficients = np.zeros(sizes.size)
    coefficients[column] = sizes[column]
    covariance = np.zeros((sizes.size, sizes.size))
    once, twice = (
        effect.parameters(factor * coefficients, covariance, nonlinear, residuals.observations)
        for factor in (1.0, 2.0)
    )
    for name, item in once.items():
        value = abs(item.value)
        if value > 0.0 and abs(abs(twice[name].value) / value - 2.0) < PROPORTIONAL:
            return Parameter(value, 0.0, item.unit)
    return None


def _columns(
    effect: Effect, nonlinear: Nonlinear, solution: Solution
) -> list[tuple[str, NDArray[np.float64]]]:
    """Columns of an effect on some rows of each channel; of the reference less their mean (a₀)."""
    observations, context = solution.observations, solution.context
    found = []
    if observations.capture is not None:
        rows = observations.capture
        thin = rows.part(slice(None, None, max(rows.run.size // MOST_ROWS, 1)))
        columns = effect.capture_columns(thin, nonlinear, context)
        if columns is not None:
            found.append(("capture", columns))
    if observations.reference is not None:
        columns = effect.reference_columns(observations.reference, nonlinear, context)
        if columns is not None:
            found.append(("reference", columns - columns.mean(axis=0)))
    return found
