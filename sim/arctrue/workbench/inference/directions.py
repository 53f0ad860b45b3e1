"""Finds the directions of a fit's unknowns that neither a row nor a condition determines.

The unknowns are the coefficients of all terms and, after them, the continuous search parameters of
each term. The covariance of a fit is a pseudo-inverse: it contains no uncertainty for a direction
that no row shows, so that results in such a direction need another test.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space

from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.named import labels, values_of
from arctrue.workbench.inference.null_space import (
    MOST_UNDETERMINED,
    is_null,
    normal_matrix,
    scaled_normal,
    share_of_null_space,
)
from arctrue.workbench.inference.solution import Solution, tangent_terms
from arctrue.workbench.inference.tangents import refined_names

Float = NDArray[np.float64]

STEP = 1e-4
"""Step of the difference quotients, in standard uncertainties of an unknown alone; rounding, about
1e-16 of a value, is then below 1e-6 of a slope for values up to a million standard
uncertainties."""


@dataclass(frozen=True, eq=False)
class Directions:
    """Directions of the unknowns that are determined, and directions that are not."""

    scale: Float
    """Weight of each unknown in the rows, (unknowns,); 1 for an unknown that no row shows."""
    undetermined: Float
    """Orthonormal directions of the scaled unknowns, (unknowns, directions)."""
    covariance: Float
    """Covariance of the unknowns in the determined directions, (unknowns, unknowns)."""

    def share(self, combinations: Float) -> Float:
        """Return, for each combination of the unknowns, the share that is not determined, (n,).

        ``combinations`` (n, unknowns): factors of the unknowns, for example the model's columns at
        an angle. The share is the length of the part in undetermined directions divided by the
        length of the combination, each unknown in units of its weight in the rows.
        """
        return share_of_null_space((self.scale, self.undetermined), combinations)


def directions_of(
    solution: Solution, *, tangents: bool = True, equations: Float | None = None
) -> Directions:
    """Return the determined and the undetermined directions of a fit.

    ``tangents``: whether the search parameters are unknowns too. ``equations`` (n, unknowns):
    slopes of conditions, which determine directions as rows do.
    """
    terms: Sequence[Term] = tangent_terms(solution)[0] if tangents else solution.terms
    size = sum(len(term.effect.column_names(solution.observations)) for term in terms)
    scale, scaled = scaled_normal(
        normal_matrix(terms, solution.observations, solution.context, solution.noise, size)
    )
    free = np.eye(scale.size)
    if equations is not None and equations.size:
        slopes = equations / scale
        size = np.linalg.norm(slopes, axis=1, keepdims=True)
        free = null_space(slopes / np.where(size > 0.0, size, 1.0))
    values, vectors = np.linalg.eigh(free.T @ scaled @ free)
    null = is_null(values)
    known = free @ vectors[:, ~null]
    covariance = (known / values[~null]) @ known.T / np.outer(scale, scale)
    return Directions(scale, free @ vectors[:, null], covariance)


def undetermined_parameters(solution: Solution, directions: Directions) -> list[str]:
    """Return the names of the reported parameters that change along an undetermined direction.

    The slopes are computed at the solution and away from it along these directions: an amplitude
    whose sine no row shows has no slope in the sine where the sine is 0. The instant of a step is
    never named: it has an uncertainty of its own.
    """
    if not directions.undetermined.shape[1]:
        return []
    here = np.concatenate(
        [
            solution.coefficients,
            [term.nonlinear[own] for term in solution.terms for own in refined_names(term.effect)],
        ]
    )
    away = here + directions.undetermined.sum(axis=1) / directions.scale
    steps = STEP / directions.scale
    (names, first), (_, second) = (_slopes(solution, at, steps) for at in (here, away))
    share = np.maximum(directions.share(first), directions.share(second))
    instants = {
        f"{label}.{term.effect.step_at[1]}"
        for label, term in zip(labels(solution.terms), solution.terms, strict=True)
        if term.effect.step_at is not None
    }
    return [
        name
        for name, part in zip(names, share, strict=True)
        if part > MOST_UNDETERMINED and name not in instants
    ]


def _slopes(solution: Solution, at: Float, steps: Float) -> tuple[list[str], Float]:
    """Return the names of all parameters and ∂(parameter)/∂(unknown), (parameters, unknowns), by
    central differences."""
    columns: list[list[float]] = []
    names: list[str] = []
    for place, step in enumerate(steps):
        moved = np.zeros(at.size)
        moved[place] = step
        above, below = _values(solution, at + moved), _values(solution, at - moved)
        names = list(above)
        rise = [above[name] - below[name] for name in names]
        columns.append(
            [
                float(np.remainder(one + 180.0, 360.0) - 180.0) if name.endswith("phase") else one
                for name, one in zip(names, rise, strict=True)
            ]
        )
    return names, np.array(columns).T / (2.0 * steps)


def _values(solution: Solution, at: Float) -> dict[str, float]:
    """Return every parameter at these values of the unknowns."""
    place = sum(solution.widths)
    terms = []
    for term in solution.terms:
        own = refined_names(term.effect)
        moved = dict(zip(own, at[place : place + len(own)].tolist(), strict=True))
        place += len(own)
        terms.append(replace(term, nonlinear={**term.nonlinear, **moved}) if own else term)
    shared = sum(solution.widths)
    return values_of(terms, solution.widths, at[:shared], solution.observations)
