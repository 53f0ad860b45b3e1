"""Searches a record for steps, which are events that occur once.

No block of a record can predict an event that occurs in another block only. A step is therefore
tested by its likelihood alone and is not named as a cause: it is reported as a jump.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.record import Record
from arctrue.workbench.inference.forward.tests_of_a_line import FAMILY_WISE, needed_gain
from arctrue.workbench.noise.kernel import KernelNoise
from arctrue.workbench.noise.kernel_fit import KernelFit, Rows, best_fit, usual_starts
from arctrue.workbench.noise.level import noise_level
from arctrue.workbench.numeric.distributions import student_log_density, student_upper_p

Float = NDArray[np.float64]

MOST_STEPS = 3
"""Largest number of steps that the search returns; it only limits the computing time."""
LEAST_SIDE_ROWS = 5
"""Smallest number of rows between a step and either end of its stretch (successive rows without a
break)."""
STEPS_TOGETHER = 200
"""Largest number of columns of one matrix product; this limit saves memory only."""
FREEDOMS = (1.5, 2.0, 3.0, 4.0, 6.0, 10.0, 20.0, 50.0, 200.0)
"""Degrees of freedom of Student's t that are tried for the tails of the whitened residuals."""


@dataclass(frozen=True)
class Step:
    """A single jump of the readings."""

    row: int
    """First averaged row after the step."""
    place: float
    """Coordinate of the step in the record, turns or seconds."""
    size_arcsec: float
    sigma_arcsec: float
    """Standard uncertainty of the size, for a step at this row."""
    gain: float


def step_column(record: Record, row: int) -> Float:
    """Return a column (rows, 1) that is 0 before ``row`` and 1 from there to the end of its
    stretch."""
    after = (np.arange(record.clock.size) >= row) & (record.stretch == record.stretch[row])
    return np.asarray(after, dtype=np.float64)[:, np.newaxis]


def search_steps(record: Record, lines: Float, fit: KernelFit) -> list[Step]:
    """Search for one step after another, each with the earlier steps in the model; return all
    steps.

    ``lines`` are the columns of the lines, and ``fit`` is the noise with these lines in the model.
    """
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
        with_step = record.rows(np.hstack([others, step_column(record, row)]))
        grown = best_fit(with_step, [without.noise, *usual_starts(with_step)])
        gain = grown.score - without.score
        if best is None or gain > best[0]:
            best = gain, row, grown
    assert best is not None
    gain, row, grown = best
    if record.of_few_rows(gain) <= needed_gain(gain, float(places.size)):
        return None
    # The largest excursion of slow noise looks like a step, and the noise estimated with this step
    # in the model is smaller. A true step is also significant with the noise that was estimated
    # without the step.
    held = float(_gains(record, rows, np.array([row]), without.noise)[0])
    # At one row, P(gain > held) = erfc(√held) < e^(−held); for all rows in ``places`` together this
    # probability may be FAMILY_WISE.
    if record.of_few_rows(held) <= np.log(places.size / FAMILY_WISE):
        return None
    column = step_column(record, row)
    if _one_row_does_it(record, others, row, gain, without, grown):
        return None
    if _tails_make_it(record, others, row, places, grown):
        return None
    if _level_makes_it(record, others, row, places, without, grown):
        return None
    with_step = record.rows(np.hstack([others, column]))
    whitened = with_step.factor(grown.noise).whiten(with_step.values)
    size = np.linalg.lstsq(whitened[:, 1:], whitened[:, 0], rcond=1e-10)[0][-1]
    model, step = whitened[:, 1:-1], whitened[:, -1]
    own = step - model @ np.linalg.lstsq(model, step, rcond=1e-10)[0]
    sigma = 1.0 / np.sqrt(record.of_few_rows(float(own @ own)))
    return Step(row, float(record.place[row]), float(size), float(sigma), gain), grown


def _inside(record: Record) -> NDArray[np.int64]:
    """Return the rows at which a step has enough rows of its stretch on both sides."""
    found = []
    for number in np.unique(record.stretch):
        own = np.flatnonzero(record.stretch == number)
        found.append(own[LEAST_SIDE_ROWS : own.size - LEAST_SIDE_ROWS + 1])
    return np.concatenate(found).astype(np.int64)


def _gains(record: Record, rows: Rows, places: NDArray[np.int64], noise: KernelNoise) -> Float:
    """Return the rise of the log likelihood by a step at each row, with the noise unchanged."""
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
    """Tell whether a single wrong row explains the rows as well: the first row after the step or
    the last row before it."""
    for wrong in (row - 1, row):
        column = np.zeros((record.clock.size, 1))
        column[wrong] = 1.0
        with_step = record.rows(np.hstack([others, column]))
        rival = best_fit(with_step, [without.noise, grown.noise])
        if rival.score - without.score >= gain:
            return True
    return False


def _tails_make_it(
    record: Record, others: Float, row: int, places: NDArray[np.int64], with_step: KernelFit
) -> bool:
    """Tell whether the tails of the noise could give a step of this size somewhere in the record.

    In a random walk each innovation is a step, so that the gains of steps at all other instants
    have the same tails as the innovations. Student's t is fitted to the square roots of twice these
    gains, and each of FREEDOMS is weighted with its likelihood. ``with_step`` is the noise with the
    step in the model.
    """
    column = record.rows(others).factor(with_step.noise).whiten(step_column(record, row))
    if float(np.max(column**2)) < FEW * float(np.sum(column**2)):
        return False
    here = np.array([row], dtype=np.int64)
    size = float(np.sqrt(2.0 * _gains(record, record.rows(others), here, with_step.noise)[0]))
    found = np.hstack([others, step_column(record, row)])
    z = np.sqrt(2.0 * _gains(record, record.rows(found), places, with_step.noise))
    z = z[z > 0.0]
    scales = np.geomspace(0.3, 1.5, 15) * float(np.sqrt(np.mean(z**2)))
    tried = [_tail(z, freedom, scales) for freedom in FREEDOMS]
    weights = np.exp(np.array([one for one, _ in tried]) - max(one for one, _ in tried))
    p_values = [
        2.0 * student_upper_p(size / scale, freedom)
        for freedom, (_, scale) in zip(FREEDOMS, tried, strict=True)
    ]
    return float(weights @ p_values / weights.sum()) * places.size > FAMILY_WISE * OF_TAILS


def _level_makes_it(
    record: Record,
    others: Float,
    row: int,
    places: NDArray[np.int64],
    without: KernelFit,
    with_step: KernelFit,
) -> bool:
    """Tell whether the step is not significant in noise whose level changes with time.

    The innovations, and the whitened columns of model and step, are divided by the local level of
    the innovations that remain with the step in the model. The gain must then reach the limit for
    all rows in ``places``, with the noise estimated without the step and with it.
    """
    column = step_column(record, row)
    rows = record.rows(np.hstack([others, column]))
    for noise in (without.noise, with_step.noise):
        whitened = rows.factor(noise).whiten(rows.values)
        own, columns = whitened[:, 0], whitened[:, 1:]
        level = noise_level(own - columns @ np.linalg.lstsq(columns, own, rcond=1e-10)[0])
        if level is None:
            continue
        own, columns = own / level.local, columns / level.local[:, np.newaxis]
        squares = [
            float(np.sum((own - used @ np.linalg.lstsq(used, own, rcond=1e-10)[0]) ** 2))
            for used in (columns[:, :-1], columns)
        ]
        free = max(own.size - columns.shape[1], 1)
        gain = 0.5 * own.size * float(np.log(squares[0] / squares[1])) * free / own.size
        if gain <= np.log(places.size / FAMILY_WISE):
            return True
    return False


def _tail(left: Float, freedom: float, scales: Float) -> tuple[float, float]:
    """Return the log likelihood of Student's t at the scale that fits best, and that scale."""
    return max(
        (float(np.sum(student_log_density(left / scale, freedom) - np.log(scale))), float(scale))
        for scale in scales
    )


OF_TAILS = 0.1
"""Share of the family-wise level that the test of the noise's tails uses. It is below 1 because the
square roots of the gains are not independent if the noise contains a random walk."""
FEW = 0.07
"""Largest share of the information about a step that a single innovation may give without a test of
the tails. At this share, more than fourteen innovations contribute to the step, and their tails
average."""
