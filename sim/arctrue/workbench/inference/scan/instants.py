"""Moves a step to the instant of its run with the largest gain, with the model projected out."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.design_matrix import Term, term_columns
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.places import BEST_PLACES, Place, peaks, scored
from arctrue.workbench.numeric.least_squares import times_of_runs

Float = NDArray[np.float64]

LEAST_STEP_ROWS = 4
"""Smallest number of rows of the run on either side of a step: one more than the largest number of
consecutive wrong rows."""
STEP_PLACES = 24
"""Number of places in a run at which the information about a step is computed; between these places
the information changes slowly and is interpolated."""
LEAST_OWN = 1e-6
"""Smallest information about a step, as a share of the largest in its run: with a smaller share,
the model explains the step, and rounding remains."""
FAR_S = 1e12
"""An instant before (negative) or after every row, seconds: the limits of the search parameter."""


def spread_places(size: int) -> NDArray[np.int64]:
    """Return places in a run of ``size`` rows, closer near its ends."""
    edge = np.unique(np.geomspace(1, size / 2, STEP_PLACES // 2).astype(np.int64))
    return np.unique(np.concatenate([edge, size - edge]))


def at_best_instant(effect: Effect, residuals: Residuals, found: list[Place]) -> list[Place]:
    """Return the places; the first is moved to the instant in its run with the largest exact gain.

    The sums over the rows of a run neglect that the model's columns absorb a part of a step. Their
    largest gain is therefore at another instant, and a further search would find a second step at
    the true instant. The absorbed part changes within a fraction of the model's shortest wave, so
    that every row is tried, with C⁻¹ times the model's columns summed from each row to the end.
    """
    capture, noise = residuals.observations.capture, residuals.solution.noise.capture
    precise, design = residuals.capture_precise, residuals.capture_precise_design
    if not found or capture is None or noise is None or precise is None or design is None:
        return found
    place = found[0].nonlinear

    def step_at(instant_s: float) -> Float:
        term = Term(effect, {**place, "instant": instant_s})
        context = residuals.solution.context
        made = term_columns(term, residuals.observations, context, capture=True)
        assert made is not None
        return np.asarray(made[:, 0])

    later = step_at(FAR_S)
    inside = step_at(-FAR_S) - later
    rows = np.flatnonzero(inside)
    rows = rows[np.argsort(capture.time_s[rows], kind="stable")]
    times, first = np.unique(capture.time_s[rows], return_index=True)
    if times.size < 2 * LEAST_STEP_ROWS:
        return found

    def summed(values: Float) -> Float:
        """Multiply values (rows, …) by the column of a step at each time; (times, …)."""
        of_time = np.add.reduceat((values[rows].T * inside[rows]).T, first, axis=0)
        return np.asarray(np.cumsum(of_time[::-1], axis=0)[::-1] + later @ values)

    tried = np.clip(spread_places(times.size), 1, times.size - 1)
    steps = np.column_stack([step_at(float(times[number])) for number in tried])
    own = np.log(np.sum(noise.whiten(steps) ** 2, axis=0))
    # The column of an offset is nonzero on the rows of its run only.
    offsets = np.zeros((times.size, design.offsets))
    offsets[:] = np.bincount(design.offset, later * design.ones, design.offsets)
    for number in np.unique(design.offset[rows]):
        offsets[:, number] = summed(np.where(design.offset == number, design.ones, 0.0))
    if design.mixed is not None:
        # The offset of a channel is in the rows of the other channels of its run too.
        offsets = times_of_runs(design.mixed.T, offsets.T).T
    absorbed = residuals.explained_squares(np.hstack([summed(design.columns), offsets]).T)
    squares = summed(precise) ** 2
    best: set[int] = set()
    # In white noise the information changes slowly from row to row; in slow noise it is that of the
    # rows next to the step, and changes with their scale.
    for local in (np.zeros(times.size), 2.0 * np.log(noise.scale[rows][first])):
        information = np.interp(np.arange(times.size), tried, own + local[tried])
        information = np.exp(information - local) - absorbed
        information = np.maximum(information, LEAST_OWN * float(information.max()))
        gains = (squares / information)[LEAST_STEP_ROWS : times.size - LEAST_STEP_ROWS + 1]
        best |= {index + LEAST_STEP_ROWS for index in peaks(gains, BEST_PLACES).tolist()}
    instants = [float(times[index]) for index in sorted(best)]
    moved = scored(effect, residuals, [{**place, "instant": item} for item in instants], 1.0)
    return sorted([*moved[:1], *found], key=lambda item: -item.gain)
