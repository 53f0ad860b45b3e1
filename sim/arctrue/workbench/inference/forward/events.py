"""Looks for what happens once in a record: a step.

No block of a record can predict what happens in another one only, so that a step is judged by its
likelihood alone, and is no cause: it is reported as what it looks like.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from arctrue.workbench.inference.forward.record import Record
from arctrue.workbench.inference.forward.tests_of_a_line import FAMILY_WISE, needed_gain
from arctrue.workbench.noise.kernel import KernelNoise
from arctrue.workbench.noise.kernel_fit import KernelFit, Rows, best_fit, usual_starts

Float = NDArray[np.float64]

MOST_STEPS = 3
LEAST_SIDE_ROWS = 5
"""Rows of its stretch before and after a step."""
STEPS_TOGETHER = 200
FREEDOMS = (1.5, 2.0, 3.0, 4.0, 6.0, 10.0, 20.0, 50.0, 200.0)
"""Of Student's t, tried for the tails of the whitened residuals."""


@dataclass(frozen=True)
class Step:
    """Something jumped, once."""

    row: int
    """First averaged row after it."""
    place: float
    """Of the record there: turns or seconds."""
    size_arcsec: float
    gain: float


def step_column(record: Record, row: int) -> Float:
    """0 before a row, 1 from it to the end of its stretch; shape (rows, 1)."""
    after = (np.arange(record.clock.size) >= row) & (record.stretch == record.stretch[row])
    return np.asarray(after, dtype=np.float64)[:, np.newaxis]


def search_steps(record: Record, lines: Float, fit: KernelFit) -> list[Step]:
    """Steps beside some lines, one after the other; ``fit`` is the noise beside the lines."""
    found: list[Step] = []
    others = lines
    while len(found) < MOST_STEPS:
        step = _next_step(record, others, fit)
        if step is None:
            break
        found.append(step[0])
        fit = step[1]
        others = np.hstack([others, step_column(record, step[0].row)])
    return found


def _next_step(record: Record, others: Float, without: KernelFit) -> tuple[Step, KernelFit] | None:
    rows = record.rows(others)
    white = KernelNoise(max(float(np.mean(rows.left() ** 2 * rows.readings)), 1e-30))
    places = _inside(record)
    if places.size == 0:
        return None
    best: tuple[float, int, KernelFit] | None = None
    for noise in (without.noise, white):
        gains = _gains(record, rows, places, noise)
        row = int(places[int(np.argmax(gains))])
        beside = record.rows(np.hstack([others, step_column(record, row)]))
        grown = best_fit(beside, [without.noise, *usual_starts(beside)])
        gain = grown.score - without.score
        if best is None or gain > best[0]:
            best = gain, row, grown
    assert best is not None
    gain, row, grown = best
    if gain <= needed_gain(gain, float(places.size)):
        return None
    column = step_column(record, row)
    if _one_row_does_it(record, others, row, gain, without, grown):
        return None
    beside = record.rows(np.hstack([others, column]))
    if _tails_make_it(beside, grown, gain, places.size):
        return None
    whitened = beside.factor(grown.noise).whiten(beside.values)
    size = np.linalg.lstsq(whitened[:, 1:], whitened[:, 0], rcond=1e-10)[0][-1]
    return Step(row, float(record.place[row]), float(size), gain), grown


def _inside(record: Record) -> NDArray[np.int64]:
    """Rows with enough of their stretch on both sides."""
    found = []
    for number in np.unique(record.stretch):
        own = np.flatnonzero(record.stretch == number)
        found.append(own[LEAST_SIDE_ROWS : own.size - LEAST_SIDE_ROWS + 1])
    return np.concatenate(found).astype(np.int64)


def _gains(record: Record, rows: Rows, places: NDArray[np.int64], noise: KernelNoise) -> Float:
    """Log likelihood that a step at each row would gain, the noise held."""
    factor = rows.factor(noise)
    whitened = factor.whiten(rows.values)
    vectors, values, _ = np.linalg.svd(whitened[:, 1:], full_matrices=False)
    model = vectors[:, values > 1e-9 * values[0]]
    own = whitened[:, 0] - model @ (model.T @ whitened[:, 0])
    number = np.arange(record.clock.size)[:, np.newaxis]
    found = np.zeros(places.size)
    for start in range(0, places.size, STEPS_TOGETHER):
        chosen = places[start : start + STEPS_TOGETHER]
        same = record.stretch[:, np.newaxis] == record.stretch[chosen]
        columns = factor.whiten(((number >= chosen) & same).astype(np.float64))
        columns -= model @ (model.T @ columns)
        square = np.einsum("ij,ij->j", columns, columns)
        part = found[start : start + STEPS_TOGETHER]
        np.divide(0.5 * (columns.T @ own) ** 2, square, out=part, where=square > 1e-9)
    return found


def _one_row_does_it(
    record: Record, others: Float, row: int, gain: float, without: KernelFit, grown: KernelFit
) -> bool:
    """A single wrong row at the step, or before it, makes the rows as likely."""
    for wrong in (row - 1, row):
        column = np.zeros((record.clock.size, 1))
        column[wrong] = 1.0
        beside = record.rows(np.hstack([others, column]))
        rival = best_fit(beside, [without.noise, grown.noise])
        if rival.score - without.score >= gain:
            return True
    return False


def _tails_make_it(rows: Rows, grown: KernelFit, gain: float, places: int) -> bool:
    """Where one innovation shows the step, tails as heavy as the others' make one as large.

    In noise that wanders a step is one large innovation. Student's t is fitted to all others; the
    step is √(2·gain) of their standard uncertainties.
    """
    whitened = rows.factor(grown.noise).whiten(rows.values)
    columns = whitened[:, 1:]
    step = columns[:, -1]
    if float(np.max(step**2)) < MOSTLY * float(np.sum(step**2)):
        return False
    left = whitened[:, 0] - columns @ np.linalg.lstsq(columns, whitened[:, 0], rcond=1e-10)[0]
    left = np.delete(left, int(np.argmax(step**2)))
    scales = np.geomspace(0.3, 1.5, 15) * float(np.std(left))
    likelihood, freedom, scale = max(
        (float(np.sum(student.logpdf(left / scale, freedom) - np.log(scale))), freedom, scale)
        for freedom in FREEDOMS
        for scale in scales
    )
    del likelihood
    if freedom <= HEAVY:
        return True
    p_value = 2.0 * float(student.sf(np.sqrt(2.0 * gain) / scale, freedom)) * places
    return p_value > FAMILY_WISE


HEAVY = 6.0
"""Degrees of freedom of Student's t below which a walk makes steps by itself: the fourth moment of
its innovations, which the fit of the tail rests on, is finite above four and known above six."""
MOSTLY = 0.5
"""Share of what is known of a step that a single innovation tells."""
