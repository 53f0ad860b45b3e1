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

from arctrue.workbench.effects.base import FitContext
from arctrue.workbench.effects.parameter import Parameter, phases_among
from arctrue.workbench.inference.design_matrix import Term, channel_sums
from arctrue.workbench.inference.fitted import Fitted
from arctrue.workbench.inference.named import labels, parameters_of
from arctrue.workbench.inference.tangents import refined_names, tangent_terms
from arctrue.workbench.noise.noise import Noise
from arctrue.workbench.numeric.least_squares import divided_by_constants
from arctrue.workbench.numeric.symmetric import RANK_TOLERANCE
from arctrue.workbench.observations import Observations

Float = NDArray[np.float64]

MOST_UNDETERMINED = 1e-3
"""Largest permitted share of a combination of coefficients that no row of the set determines. The
covariance contains no uncertainty for this share. Directions count as undetermined above a
condition number of 3e4 (RANK_TOLERANCE); small positioning errors of the targets then leave a share
below 1e-4."""
UNSEEN_WEIGHT = 1e-9
"""A column counts as rounding if its weight in the rows is at most this share of the largest
weight, the root of ``UNSEEN`` in :mod:`arctrue.workbench.numeric.symmetric`."""
ALL_CONSTANT = 1e-12
"""A column counts as a constant if, without its mean, at most this share of its sum of squares
remains. The subtraction leaves rounding of about 1e-16 times the root of the number of rows."""
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
        scaled = combinations / self.scale
        length = np.linalg.norm(scaled, axis=1)
        part = np.linalg.norm(scaled @ self.undetermined, axis=1)
        return np.asarray(part / np.where(length > 0.0, length, 1.0))


def _normal_matrix(
    terms: Sequence[Term], observations: Observations, context: FitContext, noise: Noise, size: int
) -> Float:
    """Return the normal matrix of the terms' columns over both channels, (size, size); every
    constant (of the runs, and a₀) is fitted too."""
    normal, before = np.zeros((size, size)), np.zeros(size)
    for is_capture in (True, False):
        sums = channel_sums(terms, observations, context, noise, capture=is_capture)
        if sums is None:
            continue
        # Constants (of the runs, or a₀) can replace a part of the columns, so that this part is
        # subtracted.
        own, cross = sums.gram[:size, :size], sums.gram[:size, size:]
        constants = np.array(sums.gram[size:, size:])
        unseen = np.diag(constants) <= 0.0
        constants[unseen, unseen] = 1.0
        if is_capture:
            constants[np.diag_indices_from(constants)] += 1.0 / noise.index_variance
        normal += own - divided_by_constants(cross, constants, 0.0) @ cross.T
        before += np.diag(own)
    constant = np.diag(normal) <= ALL_CONSTANT * before
    normal[constant, :] = 0.0
    normal[:, constant] = 0.0
    return normal


def _scaled_normal(normal: Float) -> tuple[Float, Float]:
    """Return the weight of each unknown in the rows, (size,), 1 for an unknown that no row shows,
    and the normal matrix in units of these weights."""
    weight = np.sqrt(np.maximum(np.diag(normal), 0.0))
    seen = weight > UNSEEN_WEIGHT * float(weight.max(initial=0.0))
    scale = np.where(seen, weight, 1.0)
    return scale, np.where(seen[:, None] & seen[None, :], normal / np.outer(scale, scale), 0.0)


def _is_null(values: Float) -> NDArray[np.bool_]:
    """Return True for eigenvalues of a scaled normal matrix whose directions are undetermined."""
    return np.asarray(values <= RANK_TOLERANCE * max(float(values.max(initial=0.0)), 1e-300))


def directions_of(
    solution: Fitted, *, tangents: bool = True, equations: Float | None = None
) -> Directions:
    """Return the determined and the undetermined directions of a fit.

    ``tangents``: whether the search parameters are unknowns too. ``equations`` (n, unknowns):
    slopes of conditions, which determine directions as rows do.
    """
    terms: Sequence[Term] = tangent_terms(solution) if tangents else solution.terms
    size = sum(len(term.effect.column_names(solution.observations)) for term in terms)
    scale, scaled = _scaled_normal(
        _normal_matrix(terms, solution.observations, solution.context, solution.noise, size)
    )
    free = np.eye(scale.size)
    if equations is not None and equations.size:
        slopes = equations / scale
        size = np.linalg.norm(slopes, axis=1, keepdims=True)
        free = null_space(slopes / np.where(size > 0.0, size, 1.0))
    values, vectors = np.linalg.eigh(free.T @ scaled @ free)
    null = _is_null(values)
    known = free @ vectors[:, ~null]
    covariance = (known / values[~null]) @ known.T / np.outer(scale, scale)
    return Directions(scale, free @ vectors[:, null], covariance)


def undetermined_parameters(solution: Fitted, directions: Directions) -> list[str]:
    """Return the names of the reported parameters that change along an undetermined direction.

    The slopes are computed at the solution and away from it along these directions: if no row shows
    the sine part of an amplitude, the amplitude has no slope in the sine where the sine is 0. The
    instant of a step is never named: it has an uncertainty of its own.
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
    names = list(_values(solution, here))
    first, second = (_slopes(solution, names, at, steps, directions) for at in (here, away))
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


def _slopes(
    solution: Fitted, names: Sequence[str], at: Float, steps: Float, directions: Directions
) -> Float:
    """Return ∂(parameter)/∂(unknown), (parameters, unknowns), by central differences.

    The slopes of a term are left at 0 if no undetermined direction changes the term's unknowns: the
    undetermined share of its parameters is at most the norm of the term's rows in
    ``directions.undetermined``.
    """
    widths = [*solution.widths, *(len(refined_names(term.effect)) for term in solution.terms)]
    owners = np.repeat(np.tile(np.arange(len(solution.terms)), 2), widths)
    squares = np.sum(directions.undetermined**2, axis=1)
    moves = np.bincount(owners, squares, len(solution.terms)) > MOST_UNDETERMINED**2
    rows = {name: row for row, name in enumerate(names)}
    phases = phases_among(_parameters(solution, at))
    found = np.zeros((len(names), at.size))
    for place in np.flatnonzero(moves[owners]).tolist():
        step, owner = steps[place], int(owners[place])
        moved = np.zeros(at.size)
        moved[place] = step
        above = _values(solution, at + moved, owner)
        below = _values(solution, at - moved, owner)
        for name, value in above.items():
            rise = value - below[name]
            if name in phases:
                rise = np.remainder(rise + 180.0, 360.0) - 180.0
            found[rows[name], place] = rise / (2.0 * step)
    return found


def _values(solution: Fitted, at: Float, owner: int | None = None) -> dict[str, float]:
    """Return the value of every parameter at these values of the unknowns; only those of one term
    if its number ``owner`` is given."""
    return {name: item.value for name, item in _parameters(solution, at, owner).items()}


def _parameters(solution: Fitted, at: Float, owner: int | None = None) -> dict[str, Parameter]:
    shared = place = sum(solution.widths)
    terms = []
    for term in solution.terms:
        own = refined_names(term.effect)
        moved = dict(zip(own, at[place : place + len(own)].tolist(), strict=True))
        place += len(own)
        terms.append(replace(term, nonlinear={**term.nonlinear, **moved}) if own else term)
    wanted = None if owner is None else {owner}
    return parameters_of(terms, solution.widths, at[:shared], solution.observations, wanted)
