"""Search parameters (a frequency, an order, a place, an instant): refined, and their uncertainty.

Variable projection, linearised at the solution: the tangents ∂(X(η)·b)/∂η join the columns of
the model as columns of their own. Their coefficients are the Gauss–Newton step in η; the inverse
of the joint normal matrix is the covariance of b and η together (Golub and Pereyra, SIAM J.
Numer. Anal. 10 (1973) 413; Seber and Wild, Nonlinear Regression, section 2.1).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Columns, Effect, FitContext, Nonlinear
from arctrue.workbench.inference.change_point import position_sigma_samples
from arctrue.workbench.inference.normal_equations import (
    Term,
    channel_sums,
    every_row_sums,
    stored_columns,
)
from arctrue.workbench.inference.solution import Solution, solve
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows

Float = NDArray[np.float64]

PROBE_ROWS = 4096
"""Rows on which the width of the difference is settled."""
RELATIVE_CHANGE = 1e-4
"""Share by which a difference moves the prediction: its cubic term is below 1e-8 of it."""
ROUNDS = 6
HALVINGS = 5
SMALL_STEP = 0.02
"""Of its own uncertainty: a step below this ends the refinement."""


def refined_names(effect: Effect) -> list[str]:
    """Search parameters that are continuous."""
    return [item.name for item in effect.search if not item.integer]


class Tangent(Effect):
    """∂(X(η)·b)/∂η of one term, by central differences; a column for each parameter."""

    name = "tangent"
    depends_on_model = True

    def __init__(self, term: Term, coefficients: Float, observations: Observations) -> None:
        """At the term's own search parameters and these coefficients."""
        super().__init__()
        self.term = term
        self.coefficients = coefficients
        self.names = refined_names(term.effect)
        self.context = FitContext()
        self.widths = {name: self._width(name, observations) for name in self.names}

    def column_names(self, observations: Observations) -> list[str]:
        """The parameters' names."""
        return list(self.names)

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        """Tangents in R₂ − R₁."""
        return self._differences(self.term.effect.capture_columns, rows, context)

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        """Tangents in ε of head 1."""
        return self._differences(self.term.effect.reference_columns, rows, context)

    def _differences(
        self, columns_of: Callable[..., Columns | None], rows: Any, context: FitContext
    ) -> Columns | None:
        found = []
        for name in self.names:
            here, width = self.term.nonlinear[name], self.widths[name]
            above = columns_of(rows, {**self.term.nonlinear, name: here + width}, context)
            below = columns_of(rows, {**self.term.nonlinear, name: here - width}, context)
            if above is None or below is None:
                return None
            found.append((above - below) @ self.coefficients / (2.0 * width))
        return np.stack(found, axis=1) if found else None

    def _width(self, name: str, observations: Observations) -> float:
        """Half the width of the difference: so small that the prediction stays straight."""
        rows = observations.capture
        probe: Any
        columns_of: Callable[..., Columns | None]
        if rows is not None:
            probe = rows.part(slice(None, None, max(rows.run.size // PROBE_ROWS, 1)))
            columns_of = self.term.effect.capture_columns
        else:
            probe = observations.reference
            columns_of = self.term.effect.reference_columns
        here = self.term.nonlinear[name]
        parameter = next(item for item in self.term.effect.search if item.name == name)
        width = 1e-7 * max(abs(here), 1e-3 * min(parameter.high - parameter.low, 1e3))
        for _ in range(3):
            now = columns_of(probe, self.term.nonlinear, self.context)
            moved = columns_of(probe, {**self.term.nonlinear, name: here + width}, self.context)
            if now is None or moved is None:
                return width
            size = float(np.linalg.norm(now @ self.coefficients))
            change = float(np.linalg.norm((moved - now) @ self.coefficients))
            if size == 0.0 or change == 0.0:
                width *= 100.0
                continue
            width *= RELATIVE_CHANGE * size / change
        return width


def _with_tangents(solution: Solution, *, every_row: bool) -> tuple[Solution, list[list[int]]]:
    """The model with its tangents, noise as it is; where each term's tangents lie."""
    observations, terms = solution.observations, list(solution.terms)
    places: list[list[int]] = []
    start = sum(solution.widths)
    for index, term in enumerate(solution.terms):
        names = refined_names(term.effect)
        places.append(list(range(start, start + len(names))))
        start += len(names)
        if names:
            own = solution.coefficients[solution.part(index)]
            terms.append(Term(Tangent(term, own, observations), {}))
    context, noise = solution.context, solution.noise
    summed = every_row_sums if every_row else channel_sums
    joint = solve(
        terms,
        observations,
        context,
        noise,
        capture=summed(terms, observations, context, noise, capture=True),
        reference=summed(terms, observations, context, noise, capture=False),
    )
    return joint, places


def joint_uncertainty(solution: Solution) -> tuple[Float, list[dict[str, float]]]:
    """Covariance of all coefficients, and of each term the σ of its search parameters.

    The coefficients' covariance allows for the search: an amplitude's phase is known the less
    where the frequency is uncertain too. A whole number (an order, a run) has no σ.
    """
    covariance = solution.covariance
    sigmas: list[dict[str, float]] = [{} for _ in solution.terms]
    if solution.held:
        return covariance, sigmas
    if any(refined_names(term.effect) for term in solution.terms):
        joint, places = _with_tangents(solution, every_row=solution.every_row)
        size = sum(solution.widths)
        covariance = joint.covariance[:size, :size]
        spread = np.sqrt(np.maximum(np.diag(joint.covariance), 0.0))
        for index, (term, own) in enumerate(zip(solution.terms, places, strict=True)):
            for name, place in zip(refined_names(term.effect), own, strict=True):
                # Zero: the data do not determine it at all.
                sigmas[index][name] = float(spread[place]) or float("nan")
    for index, term in enumerate(solution.terms):
        if term.effect.step_at is not None:
            _, instant = term.effect.step_at
            sigmas[index][instant] = _instant_sigma_s(solution, index)
    return covariance, sigmas


def _instant_sigma_s(solution: Solution, index: int) -> float:
    """Of a step between two samples: by how many samples its place scatters, and half a sample."""
    step = float(solution.coefficients[solution.part(index)][0])
    of_rows = solution.noise.capture
    noise = 0.0 if of_rows is None else of_rows.white_rms_arcsec
    scatter = position_sigma_samples(abs(step), noise)
    within_s = float(np.hypot(scatter, np.sqrt(1.0 / 12.0)) * solution.observations.sample_period_s)
    # No less sure than anywhere in the run.
    return min(within_s, solution.observations.longest_run_s / float(np.sqrt(12.0)))


def refined(solution: Solution) -> Solution:
    """The solution with its continuous search parameters at the maximum of the likelihood."""
    from arctrue.workbench.inference.solution import fit

    for _ in range(ROUNDS):
        if not any(refined_names(term.effect) for term in solution.terms):
            return solution
        joint, places = _with_tangents(solution, every_row=solution.every_row)
        spread = np.sqrt(np.maximum(np.diag(joint.covariance), 0.0))
        largest = max(
            abs(float(joint.coefficients[k])) / max(float(spread[k]), 1e-300)
            for own in places
            for k in own
        )
        if largest < SMALL_STEP:
            return solution
        share = 1.0
        for _ in range(HALVINGS):
            terms = [
                _moved(term, joint.coefficients[own] * share)
                for term, own in zip(solution.terms, places, strict=True)
            ]
            tried = fit(
                terms,
                solution.observations,
                solution.context,
                noise=solution.noise,
                every_row=solution.every_row,
            )
            if tried.log_likelihood > solution.log_likelihood:
                solution = tried
                break
            share *= 0.25
        else:
            return solution
    return solution


def _moved(term: Term, step: Float) -> Term:
    nonlinear = dict(term.nonlinear)
    for name, change in zip(refined_names(term.effect), step, strict=True):
        nonlinear[name] = float(np.clip(nonlinear[name] + change, *term.effect.search_range(name)))
    return replace(term, nonlinear=nonlinear)


def with_steps_on_every_row(solution: Solution) -> list[Term]:
    """The terms with every step moved to its best place between the rows of the part.

    A part knows the instant only to the gap between two of its stretches.
    """
    stored, part = solution.observations.stored, solution.observations.capture
    terms = list(solution.terms)
    if stored is None or part is None:
        return terms
    for index, term in enumerate(terms):
        if term.effect.step_at is None:
            continue
        run_name, instant_name = term.effect.step_at
        run = round(term.nonlinear[run_name])
        kept = part.time_s[part.run == run]
        place = int(np.searchsorted(kept, term.nonlinear[instant_name]))
        first, last = np.searchsorted(stored.run, [run, run + 1])
        times = stored.time_s[first:last]
        margin = 64
        low = max(int(np.searchsorted(times, kept[max(place - 1, 0)])) - margin, 0)
        high = int(np.searchsorted(times, kept[min(place, kept.size - 1)])) + margin
        rows = stored.rows(slice(int(first) + low, int(first) + min(high, times.size)))
        columns = stored_columns(solution.terms, solution.widths, rows, solution.context)
        own = solution.part(index).start
        step = float(solution.coefficients[own])
        columns[:, own] = 0.0
        left = rows.difference_arcsec - columns @ solution.coefficients
        left -= solution.run_offsets_arcsec[run]
        # Log likelihood of a step before row k, less that of none: Σ_{i ≥ k} step·(left − step/2).
        gain = np.cumsum((step * (left - 0.5 * step))[::-1])[::-1]
        best = float(rows.time_s[int(np.argmax(gain))])
        terms[index] = replace(term, nonlinear={**term.nonlinear, instant_name: best})
    return terms
