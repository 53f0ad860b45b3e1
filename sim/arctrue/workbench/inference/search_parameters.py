"""Refines search parameters, such as a frequency, an order, an angle or an instant.

The method is variable projection, linearised at the solution: the tangents ∂(X(η)·b)/∂η are added
to the model as further columns. Their coefficients are the Gauss–Newton step in η (Golub and
Pereyra, SIAM J. Numer. Anal. 10 (1973) 413).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.design_matrix import Term, block_columns
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.inference.tangents import refined_names

Float = NDArray[np.float64]

ROUNDS = 6
"""Largest number of Gauss–Newton steps; SMALL_STEP ends them earlier."""
HALVINGS = 5
"""Largest number of trials of a step; each step is a quarter of the step before, so that the fifth
is 1/256 of the full step."""
SMALL_STEP = 0.02
"""The refinement ends when no search parameter would change by more than this share of its own
uncertainty."""


def refined(solution: Solution) -> Solution:
    """Move the continuous search parameters of a solution to the maximum of the likelihood."""
    for _ in range(ROUNDS):
        if not any(refined_names(term.effect) for term in solution.terms):
            return solution
        joint, places = solution.with_tangents, solution.searched_parts
        spread = np.sqrt(np.maximum(np.diag(joint.covariance), 0.0))
        moves = slice(sum(solution.widths), None)
        shares = np.abs(joint.coefficients[moves]) / np.maximum(spread[moves], 1e-300)
        if shares.max() < SMALL_STEP:
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
    """Return the terms with the instant of every step moved to the best row of the whole set. The
    search covers the rows between the two rows of the sample around the instant, and 64 rows beyond
    each.

    A fit to a sample of the rows determines the instant only to within the gap between two
    successive stretches of the sample.
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
        if run < 0:
            # A step of head 1 is in every channel of its run; channel 0 shows the full step.
            run = (-run - 1) * part.channels
        kept = part.time_s[part.run == run]
        place = int(np.searchsorted(kept, term.nonlinear[instant_name]))
        first, last = np.searchsorted(stored.run, [run, run + 1])
        times = stored.time_s[first:last]
        margin = 64
        low = max(int(np.searchsorted(times, kept[max(place - 1, 0)])) - margin, 0)
        high = int(np.searchsorted(times, kept[min(place, kept.size - 1)])) + margin
        rows = stored.rows(slice(int(first) + low, int(first) + min(high, times.size)))
        columns = block_columns(solution.terms, solution.widths, rows, solution.context)
        own = solution.part(index).start
        own_channel = run % part.channels
        step = float(solution.coefficients[own])
        step *= float(part.weights[own_channel, own_channel])
        columns[:, own] = 0.0
        left = rows.difference_arcsec - columns @ solution.coefficients
        left -= rows.offsets_of_rows(solution.run_offsets_arcsec)
        # Log likelihood of a step before row k minus the log likelihood of no step: Σ_{i ≥ k}
        # step·(left − step/2).
        gain = np.cumsum((step * (left - 0.5 * step))[::-1])[::-1]
        best = float(rows.time_s[int(np.argmax(gain))])
        terms[index] = replace(term, nonlinear={**term.nonlinear, instant_name: best})
    return terms
