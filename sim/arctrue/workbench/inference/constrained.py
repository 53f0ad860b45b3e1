"""Fits with conditions on the parameters: fixed, bounded, or tied to each other.

A reported parameter (an amplitude, a frequency) is a function of coefficients and search
parameters. Near its maximum the log likelihood is a quadratic form in both. The fit maximises this
form under the conditions (sequential quadratic programming: Nocedal and Wright, Numerical
Optimization, chapter 18; ``scipy.optimize``), and computes the form anew if search parameters have
changed. Then the noise is estimated from the residuals of the constrained model, and both steps are
repeated.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import null_space
from scipy.optimize import NonlinearConstraint, minimize

from arctrue.workbench.effects.base import FitContext
from arctrue.workbench.inference.design_matrix import (
    Term,
    channel_columns,
    channel_sums,
    every_row_sums,
    term_widths,
    whitened_rows,
)
from arctrue.workbench.inference.directions import directions_of
from arctrue.workbench.inference.named import labels, values_of
from arctrue.workbench.inference.solution import (
    Held,
    Solution,
    context_of,
    joint_normal,
    solve,
)
from arctrue.workbench.inference.tangents import refined_names
from arctrue.workbench.noise.fit import noise_of
from arctrue.workbench.noise.noise import Noise
from arctrue.workbench.numeric.least_squares import ChannelSums, Layout, Matrix, WhitenedRows
from arctrue.workbench.numeric.symmetric import log_determinant
from arctrue.workbench.observations import Observations

Float = NDArray[np.float64]

ROUNDS = 8
"""Largest number of quadratic forms, one after each change of search parameters."""
SMALL_STEP = 0.02
"""The rounds end when no search parameter changes by more than this share of its own uncertainty,
as in :mod:`arctrue.workbench.inference.search_parameters`."""
NOISE_ROUNDS = 3
"""Number of noise estimates; further estimates would change the noise little."""
MET = 1e-3
"""A condition counts as met if the difference from it is at most this share of a standard
uncertainty. A bound counts as reached if the distance from it is below this share."""

POINT = 0.1
"""An equation holds only at a single point of its unknowns (such as an amplitude at 0) if its slope
there is less than this share of its slope one standard uncertainty away. The slope of an amplitude
is 1 everywhere except within the steps of the difference quotient, 1e-4 standard uncertainties,
around 0."""


class ConditionError(ValueError):
    """No values of the parameters meet the conditions."""


@dataclass(frozen=True)
class Condition:
    """One condition on named parameters.

    The condition is met where ``difference`` is zero; with ``equation`` False, where it is zero or
    more.
    """

    names: tuple[str, ...]
    difference: Callable[[Mapping[str, float]], float]
    equation: bool = True


@dataclass(frozen=True, eq=False)
class ConstrainedFit:
    """A solution that meets conditions, and the directions that the conditions leave free."""

    solution: Solution
    conditions: tuple[Condition, ...]
    covariance: Float
    """Covariance of all coefficients and, after them, of the continuous search parameters of each
    term."""
    free: Float
    """Orthonormal directions in which the coefficients are free, shape (coefficients, free)."""
    slopes: Float
    """Slopes of every equation and of every reached bound, shape (slopes, unknowns)."""
    is_equation: NDArray[np.bool_]
    """True for the slopes that belong to equations, shape (slopes,)."""
    covariance_of_equations: Float
    """Covariance of the same unknowns, as if no bound had been reached."""

    @property
    def equations(self) -> Float:
        """Slopes of the equations, shape (equations, unknowns)."""
        return np.asarray(self.slopes[self.is_equation])


def constrained_fit(solution: Solution, conditions: Sequence[Condition]) -> ConstrainedFit:
    """Fit ``solution`` with conditions on its parameters; estimate coefficients and noise anew.

    Without conditions, the noise stays as it is. Raises ConditionError where no values meet the
    conditions.
    """
    found = conditioned(solution, conditions)
    for _ in range(NOISE_ROUNDS if conditions else 0):
        noise = noise_with(found)
        found = conditioned(replace(found.solution, noise=noise), conditions)
    if not found.slopes.size or not directions_of(found.solution).undetermined.size:
        return found
    # The rows may determine unknowns only in combination. In a pseudo-inverse, such unknowns vary
    # together, so that a condition on one of them would seem to determine the others.
    kept = directions_of(found.solution, equations=found.slopes).covariance
    shared = sum(found.solution.widths)
    return replace(
        found,
        solution=replace(found.solution, covariance=kept[:shared, :shared]),
        covariance=kept,
        covariance_of_equations=directions_of(found.solution, equations=found.equations).covariance,
    )


def conditioned(solution: Solution, conditions: Sequence[Condition]) -> ConstrainedFit:
    """Fit ``solution`` with conditions on its parameters; the noise stays as it is."""
    present = _solved(solution, list(solution.terms), None)
    for _ in range(ROUNDS):
        unknowns = _Unknowns.of(present)
        wanted, involved, slopes, is_equation = _nearest(unknowns, conditions)
        moved = unknowns.moved_terms(wanted)
        shared = sum(present.widths)
        held = involved[involved < shared]
        step = np.abs(wanted[shared:] - unknowns.values[shared:]) if wanted.size > shared else 0.0
        before = present
        present = _solved(before, moved, Held(held, wanted[held]) if held.size else None)
        if np.all(step <= SMALL_STEP * np.maximum(unknowns.spread[shared:], 1e-300)):
            break
    covariance = _covariance_under(unknowns.covariance, slopes)
    present = replace(
        present,
        context=context_of(present),
        covariance=covariance[:shared, :shared],
        rank=unknowns.rank - int(np.count_nonzero(np.any(slopes[:, :shared] != 0.0, axis=1))),
    )
    return ConstrainedFit(
        present,
        tuple(conditions),
        covariance,
        _free_directions(slopes[:, :shared]),
        slopes,
        is_equation,
        _covariance_under(unknowns.covariance, slopes[is_equation]),
    )


def _covariance_under(covariance: Float, slopes: Float) -> Float:
    """Return the covariance of the unknowns while their combinations ``slopes`` (n, unknowns) are
    held constant."""
    if not slopes.size:
        return covariance
    across = covariance @ slopes.T
    return np.asarray(covariance - across @ np.linalg.pinv(slopes @ across) @ across.T)


def _solved(solution: Solution, terms: list[Term], held: Held | None) -> Solution:
    """Solve for the coefficients of ``terms``, with the noise, context and rows of ``solution``."""
    summed = every_row_sums if solution.every_row else channel_sums
    observations, context, noise = solution.observations, solution.context, solution.noise
    found = solve(
        terms,
        observations,
        context,
        noise,
        capture=summed(terms, observations, context, noise, capture=True),
        reference=summed(terms, observations, context, noise, capture=False),
        held=held,
    )
    return replace(found, every_row=solution.every_row, unknown_noise=solution.unknown_noise)


@dataclass(frozen=True)
class _Unknowns:
    """The quadratic form of the log likelihood at a solution; its unknowns are the coefficients,
    then the continuous search parameters."""

    solution: Solution
    values: Float
    """Values at the solution."""
    best: Float
    """Values at the maximum of the form."""
    covariance: Float
    rank: int

    @classmethod
    def of(cls, solution: Solution) -> _Unknowns:
        names = [refined_names(term.effect) for term in solution.terms]
        here = [
            term.nonlinear[name]
            for term, own in zip(solution.terms, names, strict=True)
            for name in own
        ]
        shared = sum(solution.widths)
        if not here:
            free = _solved(solution, list(solution.terms), None)
            return cls(
                solution, solution.coefficients, free.coefficients, free.covariance, free.rank
            )
        joint = solution.with_tangents
        best = joint.coefficients.copy()
        best[shared:] += here
        values = np.concatenate([solution.coefficients, here])
        return cls(solution, values, best, joint.covariance, joint.rank - len(here))

    @property
    def spread(self) -> Float:
        """Standard uncertainties."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))

    def moved_terms(self, values: Float) -> list[Term]:
        """Return the terms with the search parameters from ``values``, within their declared
        ranges."""
        place = sum(self.solution.widths)
        found = []
        for term in self.solution.terms:
            nonlinear = dict(term.nonlinear)
            for name in refined_names(term.effect):
                low, high = term.effect.search_range(name)
                nonlinear[name] = float(np.clip(values[place], low, high))
                place += 1
            found.append(replace(term, nonlinear=nonlinear) if nonlinear else term)
        return found

    def differences(self, values: Float, conditions: Sequence[Condition]) -> Float:
        """Return ``difference`` of every condition at these values."""
        named = labels(self.solution.terms)
        read = {name.rpartition(".")[0] for item in conditions for name in item.names}
        wanted = {number for number, label in enumerate(named) if label in read}
        shared = sum(self.solution.widths)
        parameters = values_of(
            self.moved_terms(values),
            self.solution.widths,
            values[:shared],
            self.solution.observations,
            wanted,
        )
        return np.array([item.difference(parameters) for item in conditions])


def _nearest(
    unknowns: _Unknowns, conditions: Sequence[Condition]
) -> tuple[Float, NDArray[np.int64], Float, NDArray[np.bool_]]:
    """Return the likeliest values that meet the conditions, the unknowns on which the conditions
    depend, the slopes, and True for the slopes that belong to equations.

    The slopes are derivatives of every equation, and of every bound that is reached, with respect
    to all unknowns. If a condition holds an amplitude at 0, all unknowns of this amplitude are 0.
    """
    none = (
        np.zeros(0, dtype=np.int64),
        np.zeros((0, unknowns.best.size)),
        np.zeros(0, dtype=np.bool_),
    )
    if not conditions:
        return unknowns.best, *none
    spread = unknowns.spread
    at = unknowns.best
    slopes = _slopes(unknowns, at, conditions)
    if not slopes.any():
        # An amplitude of zero has no derivative; after a small step, the derivatives show on which
        # unknowns the amplitude depends.
        slopes = _slopes(unknowns, at + spread, conditions)
    involved = np.flatnonzero(slopes.any(axis=0) & (spread > 0.0))
    if not involved.size:
        lost = ", ".join(name for item in conditions for name in item.names)
        raise ConditionError(f"{lost}: the data do not determine the parameters of this condition")
    own = unknowns.covariance[np.ix_(involved, involved)]
    values, vectors = np.linalg.eigh(own / np.outer(spread[involved], spread[involved]))
    root = vectors * np.sqrt(np.maximum(values, 1e-14)) * spread[involved][:, np.newaxis]
    # ``root @ steps`` is the change of the unknowns; the log likelihood then falls by half the
    # square of the length of ``steps``.
    scale = np.maximum(np.linalg.norm(slopes[:, involved] @ root, axis=1), 1e-300)

    def place(steps: Float) -> Float:
        moved = at.copy()
        moved[involved] += root @ steps
        return moved

    def difference(steps: Float) -> Float:
        return np.asarray(unknowns.differences(place(steps), conditions) / scale)

    start = _start(difference, slopes[:, involved] @ root / scale[:, np.newaxis], conditions)
    kinds = [item.equation for item in conditions]

    def square(steps: Float) -> float:
        return 0.5 * float(steps @ steps)

    def slope(steps: Float) -> Float:
        return steps

    found = minimize(
        square,
        start,
        jac=slope,
        method="SLSQP",
        constraints=_asked(difference, np.array(kinds)),
        options={"ftol": 1e-12, "maxiter": 200},
    )
    left = difference(found.x)
    bad = np.where(kinds, np.abs(left), np.maximum(-left, 0.0))
    if float(bad.max()) > MET:
        worst = conditions[int(np.argmax(bad))]
        raise ConditionError(
            f"{', '.join(worst.names)}: no values meet the condition together with the others"
        )
    wanted = place(found.x)
    # The conditions do not depend on the other unknowns: these take their likeliest values.
    rest = np.setdiff1d(np.arange(wanted.size), involved)
    shift = np.linalg.pinv(own) @ (wanted[involved] - at[involved])
    wanted[rest] += unknowns.covariance[np.ix_(rest, involved)] @ shift
    reached = np.array(kinds) | (left < MET)
    if not reached.any():
        return wanted, *none
    return wanted, involved, *_kept(unknowns, wanted, conditions, reached)


def _kept(
    unknowns: _Unknowns,
    wanted: Float,
    conditions: Sequence[Condition],
    reached: NDArray[np.bool_],
) -> tuple[Float, NDArray[np.bool_]]:
    """Return the combinations of the unknowns that the reached conditions hold constant, (n,
    unknowns), and True for the combinations that belong to equations."""
    spread = unknowns.spread
    slopes, near = (_slopes(unknowns, at, conditions) for at in (wanted, wanted + spread))
    found: list[Float] = []
    is_equation: list[bool] = []
    for number in np.flatnonzero(reached).tolist():
        size, usual = (float(np.linalg.norm(one[number] * spread)) for one in (slopes, near))
        rows = slopes[number : number + 1]
        if conditions[number].equation and size < POINT * usual:
            rows = np.eye(spread.size)[near[number] != 0.0]
        found.append(rows)
        is_equation += [conditions[number].equation] * len(rows)
    return np.concatenate(found), np.array(is_equation, dtype=np.bool_)


def _asked(
    difference: Callable[[Float], Float], equation: NDArray[np.bool_]
) -> list[NonlinearConstraint]:
    """Return the conditions in scipy's form: one constraint for equations, one for bounds."""

    def of_kind(kind: bool) -> Callable[[Float], Float]:
        return lambda steps: difference(steps)[equation == kind]

    return [
        NonlinearConstraint(of_kind(kind), 0.0, highest)
        for kind, highest in ((True, 0.0), (False, np.inf))
        if np.any(equation == kind)
    ]


def _start(
    difference: Callable[[Float], Float], slopes: Float, conditions: Sequence[Condition]
) -> Float:
    """Return the shortest step that meets the linearised conditions, as the start of the search."""
    here = difference(np.zeros(slopes.shape[1]))
    kinds = [item.equation for item in conditions]
    lacking = np.where(kinds, here, np.minimum(here, 0.0))
    return np.asarray(-np.linalg.pinv(slopes) @ lacking)


def _slopes(unknowns: _Unknowns, at: Float, conditions: Sequence[Condition]) -> Float:
    """Return ∂(difference)/∂(unknown) by central differences, shape (conditions, unknowns)."""
    found = np.zeros((len(conditions), at.size))
    spread = unknowns.spread
    for place in range(at.size):
        width = 1e-4 * spread[place]
        if width <= 0.0 or not np.isfinite(width):
            continue
        above, below = at.copy(), at.copy()
        above[place] += width
        below[place] -= width
        rise = unknowns.differences(above, conditions) - unknowns.differences(below, conditions)
        found[:, place] = rise / (2.0 * width)
    size = np.linalg.norm(found * spread, axis=1, keepdims=True)
    found[np.abs(found * spread) < 1e-7 * np.maximum(size, 1e-300)] = 0.0
    return found


def _free_directions(slopes: Float) -> Float:
    """Return orthonormal directions in which no condition changes, shape (coefficients, free)."""
    size = slopes.shape[1]
    involved = np.flatnonzero(slopes.any(axis=0))
    if not involved.size:
        return np.eye(size)
    scale = np.abs(slopes[:, involved]).max()
    inside = null_space(slopes[:, involved] / scale)
    others = np.setdiff1d(np.arange(size), involved)
    found = np.zeros((size, others.size + inside.shape[1]))
    found[others, np.arange(others.size)] = 1.0
    found[np.ix_(involved, np.arange(others.size, found.shape[1]))] = inside
    return found


@dataclass(frozen=True)
class FreeDesign:
    """The design matrix of a model in the directions that its conditions leave free."""

    terms: Sequence[Term]
    observations: Observations
    context: FitContext
    free: Float

    @property
    def shared(self) -> int:
        """Number of free directions."""
        return int(self.free.shape[1])

    def columns(self, *, capture: bool) -> Matrix:
        """Return the columns of a channel along the free directions, shape (rows, shared),
        arcseconds."""
        every = channel_columns(self.terms, self.observations, self.context, capture=capture)
        return np.asarray(every @ self.free)

    def whitened(self, noise: Noise, *, capture: bool) -> WhitenedRows | None:
        """Return the columns of a channel, whitened by ``noise``; None if the set lacks that
        channel."""
        found = whitened_rows(self.terms, self.observations, self.context, noise, capture=capture)
        return None if found is None else replace(found, columns=found.columns @ self.free)

    def sums(self, noise: Noise, *, capture: bool) -> ChannelSums | None:
        """Return the sums of least squares over the rows of a channel; None if the set lacks that
        channel."""
        sums = channel_sums(self.terms, self.observations, self.context, noise, capture=capture)
        if sums is None:
            return None
        all_places = sum(term_widths(self.terms, self.observations))
        constants = sums.moment.size - all_places
        turn = np.zeros((sums.moment.size, self.shared + constants))
        turn[:all_places, : self.shared] = self.free
        turn[all_places:, self.shared :] = np.eye(constants)
        return replace(sums, gram=turn.T @ sums.gram @ turn, moment=turn.T @ sums.moment)


def noise_with(found: ConstrainedFit, free: Float | None = None) -> Noise:
    """Estimate the noise from the residuals of a model with conditions, starting from its present
    noise.

    ``free``: directions in which the coefficients absorb noise; by default the free directions of
    ``found``.
    """
    solution = found.solution
    design = FreeDesign(
        solution.terms, solution.observations, solution.context,
        found.free if free is None else free,
    )  # fmt: skip
    left = solution.capture_residual_arcsec(), solution.reference_residual_arcsec()
    noise = noise_of(design, left, solution.noise, solution.unknown_noise)
    return noise.with_offsets(solution.observations, solution.run_offsets_arcsec)


def restricted_likelihood_of(found: ConstrainedFit, free: Float) -> float:
    """Return the log likelihood with the free coefficients integrated out and the prior of the
    index variance included.

    It is :func:`arctrue.workbench.inference.likelihood_ratio.restricted_likelihood` for a model
    with conditions.
    """
    solution, noise = found.solution, found.solution.noise
    observations = solution.observations
    design = FreeDesign(solution.terms, observations, solution.context, free)
    layout = Layout(design.shared, observations.runs)
    sums = design.sums(noise, capture=True), design.sums(noise, capture=False)
    normal, _ = joint_normal(layout, noise, *sums)
    total = solution.log_likelihood - 0.5 * log_determinant(normal)
    if observations.runs:
        prior = observations.index_sigma_arcsec**2
        total -= (
            0.5
            * noise.index_freedom
            * (float(np.log(noise.index_variance)) + prior / noise.index_variance)
        )
    return total
