"""Compares each column of an effect with finite differences of the effect's own formula."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]

STEP = 1e-3
"""Step of a coefficient, in its unit; a linear formula has the same difference quotient at any
step.
"""
FAR = 1.0
"""Change of a coefficient, in its unit, with which the linearity of the formula is tested."""
ROUNDING = 1e-6
"""Largest relative difference that counts as rounding: a step of 1e-3 leaves 13 of 16 digits, and
the limit has a margin."""

Forward = Callable[[dict[str, float]], Float]
"""Function that calculates the formula's values in arcseconds, shape (rows,), from the coefficients
by name."""


def formula_faults(forward: Forward, names: Sequence[str], columns: Float) -> list[str]:
    """Describe where the columns, shape (rows, coefficients), differ from the formula; ``[]`` if
    nowhere."""
    at = {name: 0.5 + 0.25 * place for place, name in enumerate(names)}
    faults = _faults_of_zero(forward, at)
    for place, name in enumerate(names):
        slope = _difference(forward, at, name, STEP)
        scale = max(float(np.abs(slope).max()), float(np.abs(columns[:, place]).max()), 1e-12)
        bend = forward(_moved(at, name, FAR)) + forward(_moved(at, name, -FAR)) - 2.0 * forward(at)
        if float(np.abs(bend).max()) > ROUNDING * scale:
            faults.append(
                f"{name}: the formula is not linear in this coefficient; declare a nonlinear "
                "quantity in search"
            )
            continue
        off = np.abs(columns[:, place] - slope)
        row = int(np.argmax(off))
        if off[row] > ROUNDING * scale:
            faults.append(
                f"{name}: row {row} has {columns[row, place]:.6g} in the column, but "
                f"{slope[row]:.6g} by the formula{_hint(columns[:, place], slope)}"
            )
    return faults


def _faults_of_zero(forward: Forward, at: dict[str, float]) -> list[str]:
    rest = forward(dict.fromkeys(at, 0.0))
    if float(np.abs(rest).max()) <= 1e-9:
        return []
    return [
        "the formula is not zero when all coefficients are zero: no column can describe that part"
    ]


def _moved(at: dict[str, float], name: str, step: float) -> dict[str, float]:
    return {**at, name: at[name] + step}


def _difference(forward: Forward, at: dict[str, float], name: str, step: float) -> Float:
    """Return the difference quotient (f(b + h) − f(b − h)) / 2h."""
    up, down = forward(_moved(at, name, step)), forward(_moved(at, name, -step))
    return np.asarray((up - down) / (2.0 * step))


def _hint(column: Float, slope: Float) -> str:
    """Describe the ratio of column to slope in words; empty if the rows have different ratios."""
    square = float(slope @ slope)
    if square == 0.0:
        return "; the formula does not contain this coefficient"
    factor = float(column @ slope) / square
    if np.abs(column - factor * slope).max() > ROUNDING * max(np.abs(column).max(), 1e-12):
        return ""
    return "; the sign is wrong" if abs(factor + 1.0) < ROUNDING else f"; ratio {factor:.6g}"
