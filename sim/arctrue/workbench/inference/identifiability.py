"""Finds the coefficients that a set determines, and the smallest effects that the set could
show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.detectable import smallest_detectable
from arctrue.workbench.inference.directions import directions_of
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.solution import Solution

STRONG_CORRELATION = 0.9
"""Pairs of coefficients with a larger correlation are listed; no decision uses this limit. At this
correlation each σ is 2.3 times the σ of the coefficient alone, 1/√(1 − 0.9²)."""
UNDETERMINED_SHARE = 0.5
"""If a larger share of a coefficient lies in directions that no row shows, the coefficient counts
as not determined."""
MOST_PAIRS = 20
"""Largest number of pairs that are listed."""


@dataclass(frozen=True)
class Pair:
    """Two coefficients that the data hardly separate."""

    first: str
    second: str
    correlation: float


@dataclass(frozen=True)
class Identifiability:
    """States which coefficients of a fitted model a set determines, and how well."""

    coefficients: list[str]
    rank: int
    condition: float
    undetermined: list[str]
    """Coefficients that have no effect on any row, or that other coefficients can replace
    exactly."""
    weakest: dict[str, float]
    """σ of the three coefficients with the largest σ, arcseconds (or their unit), by name."""
    correlated: list[Pair]
    smallest_arcsec: dict[str, dict[str, float]] = field(default_factory=dict)
    """Smallest detectable RMS of each absent effect without search parameters, by channel. At this
    RMS, the gain of the effect is significant in 95 % of such sets, at a level of 1 % divided by
    the number of absent effects. The test on held-out rows is not included."""


def coefficient_names(solution: Solution) -> list[str]:
    """Return ``effect: column`` of every coefficient, in the order of the coefficients."""
    return [
        f"{term.effect.name}: {name}"
        for term in solution.terms
        for name in term.effect.column_names(solution.observations)
    ]


def identifiability(
    solution: Solution, absent: Mapping[str, type[Effect]] | None = None
) -> Identifiability:
    """Return rank, condition, undetermined and correlated coefficients, and detectable effects."""
    names = coefficient_names(solution)
    covariance = solution.covariance
    sigma = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    lost = _undetermined(solution)
    known = np.flatnonzero((sigma > 0.0) & ~lost)
    strongest = known[np.argsort(sigma[known])[::-1][:3]]
    return Identifiability(
        coefficients=names,
        rank=solution.rank,
        condition=solution.condition,
        undetermined=[name for name, is_lost in zip(names, lost, strict=True) if is_lost],
        weakest={names[index]: float(sigma[index]) for index in strongest},
        correlated=_pairs(names, covariance, sigma, known),
        smallest_arcsec=_smallest(solution, absent or {}),
    )


def undetermined_names(solution: Solution) -> list[str]:
    """Return the names of the coefficients that the rows do not determine."""
    names = coefficient_names(solution)
    lost = _undetermined(solution)
    return [name for name, is_lost in zip(names, lost, strict=True) if is_lost]


def _undetermined(solution: Solution) -> NDArray[np.bool_]:
    """Return True for coefficients that lie mostly in the null space of both channels together."""
    null = directions_of(solution, tangents=False).undetermined
    return np.asarray(np.sum(null**2, axis=1) > UNDETERMINED_SHARE)


def _pairs(
    names: list[str],
    covariance: NDArray[np.float64],
    sigma: NDArray[np.float64],
    known: NDArray[np.int64],
) -> list[Pair]:
    correlation = covariance[np.ix_(known, known)] / np.outer(sigma[known], sigma[known])
    first, second = np.triu_indices(known.size, 1)
    strength = np.abs(correlation[first, second])
    order = np.argsort(strength)[::-1][:MOST_PAIRS]
    return [
        Pair(
            names[known[first[k]]],
            names[known[second[k]]],
            float(correlation[first[k], second[k]]),
        )
        for k in order
        if strength[k] > STRONG_CORRELATION
    ]


def _smallest(
    solution: Solution, absent: Mapping[str, type[Effect]]
) -> dict[str, dict[str, float]]:
    observations, residuals = solution.observations, Residuals(solution)
    found: dict[str, dict[str, float]] = {}
    for name, kind in absent.items():
        effect = kind()
        if effect.search or effect.missing(observations):
            continue
        smallest = smallest_detectable(residuals, effect, {}, float(len(absent)))
        if smallest is not None:
            found[name] = smallest.rms_arcsec
    return found
