"""Searches a record for steps, which are events that no other part of the record repeats.

No block of a record can predict an event that occurs in another block only. A step is therefore
tested by its likelihood alone and is not named as a cause: it is reported as a jump.
"""

from __future__ import annotations

from collections.abc import Sequence
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

MOST_STEPS = 16
"""Largest number of steps that the search returns; it only limits the computing time."""
LEAST_SIDE_ROWS = 5
"""Smallest number of rows between a step and either end of its stretch (successive rows without a
break)."""
MOST_SHARES = 8
"""Largest number of readings of one mean that are tried as the first after a step. A step is then
too small by at most 1/16 of the weight of one mean."""
ROUNDING = 1e-6
"""The stated time of a step is earlier than its first reading by this share of a reading's step, so
that this reading comes after the step in spite of rounding."""
STEPS_TOGETHER = 200
"""Largest number of columns of one matrix product; this limit saves memory only."""
FREEDOMS = (1.5, 2.0, 3.0, 4.0, 6.0, 10.0, 20.0, 50.0, 200.0)
"""Degrees of freedom of Student's t that are tried for the tails of the whitened residuals."""


@dataclass(frozen=True)
class Step:
    """A jump of the readings."""

    row: int
    """First averaged row after the step."""
    place: float
    """Coordinate of the step in the record, turns or seconds."""
    size_arcsec: float
    sigma_arcsec: float
    """Standard uncertainty of the size, for a step at this row."""
    gain: float
    """Rise of the log likelihood by this step, with the other steps in the model."""
    share: float = 1.0
    """Share of the readings in the mean of ``row`` that come after the step."""

    def measured(self, record: Record) -> float:
        """Return time or row number of the first reading after the step, on the measured clock."""
        middle, readings = float(record.measured[self.row]), float(record.readings[self.row])
        if readings == 1.0:
            return middle
        before = readings * (1.0 - self.share)
        return middle + (before - 0.5 * (readings - 1.0) - ROUNDING) * record.step / readings


def step_column(record: Record, row: int, share: float = 1.0) -> Float:
    """Return a column (rows, 1) that is 0 before ``row``, ``share`` at ``row``, and 1 from there to
    the end of its stretch."""
    after = (np.arange(record.clock.size) >= row) & (record.stretch == record.stretch[row])
    column = np.asarray(after, dtype=np.float64)[:, np.newaxis]
    column[row] = share
    return column


def columns_of_steps(record: Record, steps: Sequence[Step]) -> Float:
    """Return the columns of steps, shape (rows, steps)."""
    none = np.zeros((record.clock.size, 0))
    return np.hstack([none, *(step_column(record, step.row, step.share) for step in steps)])


def search_steps(record: Record, lines: Float, fit: KernelFit) -> list[Step]:
    """Search for one step after another, each with the earlier steps in the model; return all steps
    that the tails and the level of the noise cannot explain.

    ``lines`` are the columns of the lines, and ``fit`` is the noise with these lines in the model.
    The steps that are not yet in the model look like heavy tails of the noise. The tails are
    therefore tested with all steps in the model, and the step that they explain best is removed
    until they explain none.
    """
    places = _inside(record)
    rows: list[int] = []
    grown = fit
    while len(rows) < MOST_STEPS:
        step = _next_step(record, _with_steps(record, lines, rows), places, grown)
        if step is None:
            break
        rows.append(step[0])
        grown = step[1]
    while rows:
        wrong = _explained_by_noise(record, lines, rows, places, fit, grown)
        if wrong is None:
            return _sized(record, lines, rows, fit, grown)
        rows.remove(wrong)
        left = record.rows(_with_steps(record, lines, rows))
        grown = best_fit(left, [fit.noise, grown.noise, *usual_starts(left)])
    return []


def _with_steps(record: Record, lines: Float, rows: Sequence[int]) -> Float:
    """Return the columns of the lines and of steps at ``rows``."""
    return np.hstack([lines, *(step_column(record, row) for row in rows)])


def _next_step(
    record: Record, others: Float, places: NDArray[np.int64], without: KernelFit
) -> tuple[int, KernelFit] | None:
    """Return the row of the step with the highest gain and the noise with this step, or None if the
    step is not significant."""
    rows = record.rows(others)
    white = KernelNoise(max(float(np.mean(rows.left() ** 2 * rows.readings)), 1e-30))
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
    if _one_row_does_it(record, others, row, gain, without, grown):
        return None
    return row, grown


def _without(
    record: Record,
    lines: Float,
    rows: Sequence[int],
    row: int,
    without_all: KernelFit,
    with_all: KernelFit,
) -> tuple[Float, KernelFit]:
    """Return the columns of the lines and of all steps except that at ``row``, and the noise with
    them."""
    if len(rows) == 1:
        return lines, without_all
    others = _with_steps(record, lines, [item for item in rows if item != row])
    left = record.rows(others)
    return others, best_fit(left, [without_all.noise, with_all.noise, *usual_starts(left)])


def _explained_by_noise(
    record: Record,
    lines: Float,
    rows: Sequence[int],
    places: NDArray[np.int64],
    without_all: KernelFit,
    with_all: KernelFit,
) -> int | None:
    """Return the row of the step that the tails of the noise explain best, or of the first step
    that a changing level explains; None if the noise explains no step."""
    found = [_p_of_tails(record, lines, rows, row, places, with_all) for row in rows]
    worst = int(np.argmax(found))
    if found[worst] > FAMILY_WISE * OF_TAILS:
        return rows[worst]
    for row in rows:
        others, without = _without(record, lines, rows, row, without_all, with_all)
        if _level_makes_it(record, others, row, places, without, with_all):
            return row
    return None


def _sized(
    record: Record,
    lines: Float,
    rows: Sequence[int],
    without_all: KernelFit,
    with_all: KernelFit,
) -> list[Step]:
    """Return the steps with their sizes, which are fitted together."""
    at = [(row, 1.0) for row in rows]
    fit = with_all
    if np.any(record.readings > 1.0):
        at = _within_their_rows(record, lines, rows, with_all.noise)
        left = record.rows(_with_shares(record, lines, at))
        fit = best_fit(left, [with_all.noise, *usual_starts(left)])
    fitted = record.rows(_with_shares(record, lines, at))
    whitened = fitted.factor(fit.noise).whiten(fitted.values)
    own, columns = whitened[:, 0], whitened[:, 1:]
    sizes = np.linalg.lstsq(columns, own, rcond=1e-10)[0][-len(rows) :]
    steps = []
    for number, (row, share) in enumerate(at):
        place = columns.shape[1] - len(rows) + number
        model, step = np.delete(columns, place, axis=1), columns[:, place]
        alone = step - model @ np.linalg.lstsq(model, step, rcond=1e-10)[0]
        sigma = 1.0 / np.sqrt(record.of_few_rows(float(alone @ alone)))
        _, without = _without(record, lines, rows, rows[number], without_all, with_all)
        gain = with_all.score - without.score
        where = float(record.place[row])
        steps.append(Step(row, where, float(sizes[number]), float(sigma), gain, share))
    return steps


def _with_shares(record: Record, lines: Float, at: Sequence[tuple[int, float]]) -> Float:
    """Return the columns of the lines and of steps, each with its row and its share of this row."""
    return np.hstack([lines, *(step_column(record, row, share) for row, share in at)])


def _within_their_rows(
    record: Record, lines: Float, rows: Sequence[int], noise: KernelNoise
) -> list[tuple[int, float]]:
    """Return row and share of each step: the most likely reading among those whose means are its
    row and the row before it. A step in the middle of a mean would otherwise seem too small."""
    at = [(row, 1.0) for row in rows]
    for number, row in enumerate(rows):
        places = [(row, float(share)) for share in _shares(record.readings[row])]
        if record.stretch[row - 1] == record.stretch[row]:
            before = _shares(record.readings[row - 1])[:-1]
            places += [(row - 1, float(share)) for share in before]
        squares = []
        for place in places:
            others = [item for other, item in enumerate(at) if other != number]
            tried = record.rows(_with_shares(record, lines, [*others, place]))
            whitened = tried.factor(noise).whiten(tried.values)
            own, columns = whitened[:, 0], whitened[:, 1:]
            left = own - columns @ np.linalg.lstsq(columns, own, rcond=1e-10)[0]
            squares.append(float(left @ left))
        at[number] = places[int(np.argmin(squares))]
    return at


def _shares(readings: float) -> Float:
    """Return the tried shares of a mean's readings after a step, the whole mean last."""
    count = round(float(readings))
    return np.unique(np.ceil(np.linspace(1, count, min(count, MOST_SHARES)))) / count


def _inside(record: Record) -> NDArray[np.int64]:
    """Return the rows at which a step has enough rows of its stretch on both sides, and is no curve
    of the base."""
    found = []
    for number in np.unique(record.stretch):
        own = np.flatnonzero(record.stretch == number)
        found.append(own[LEAST_SIDE_ROWS : own.size - LEAST_SIDE_ROWS + 1])
    rows = np.concatenate(found).astype(np.int64)
    return rows[_own_shares(record, rows) > LEAST_OWN]


LEAST_OWN = 1e-3
"""Smallest share of a step's sum of squares, after its mean, that the base leaves; the step's u is
then at most 32 times that without the base (1/√0.001). Passes one after another show why: the time
minus the angle of the pass is a step at each start of a pass."""


def _own_shares(record: Record, rows: NDArray[np.int64]) -> Float:
    """Return the share of the sum of squares of a step at each row that the base leaves."""
    found = np.zeros(rows.size)
    for number in np.unique(record.stretch):
        own = np.flatnonzero(record.stretch == number)
        inside = np.isin(rows, own)
        first = rows[inside] - own[0]
        # The sum of each column of the base from each row to the end of the stretch.
        sums = np.cumsum(record.base[own][::-1], axis=0)[::-1][first]
        after = own.size - first
        whole = after * first / own.size
        found[inside] = (after - np.sum(sums**2, axis=1)) / np.maximum(whole, 1e-300)
    return found


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


def _p_of_tails(
    record: Record,
    lines: Float,
    rows: Sequence[int],
    row: int,
    places: NDArray[np.int64],
    with_steps: KernelFit,
) -> float:
    """Return the probability that the tails of the noise give a step of this size somewhere in the
    record; 0 if many innovations determine the step.

    In a random walk each innovation is a step, so that the gains of steps at all other instants
    have the same tails as the innovations. Student's t is fitted to the square roots of twice these
    gains, and each of FREEDOMS is weighted with its likelihood. ``with_steps`` is the noise with
    the steps at ``rows`` in the model.
    """
    others = _with_steps(record, lines, [item for item in rows if item != row])
    column = record.rows(others).factor(with_steps.noise).whiten(step_column(record, row))
    if float(np.max(column**2)) < FEW * float(np.sum(column**2)):
        return 0.0
    here = np.array([row], dtype=np.int64)
    size = float(np.sqrt(2.0 * _gains(record, record.rows(others), here, with_steps.noise)[0]))
    found = _with_steps(record, lines, rows)
    z = np.sqrt(2.0 * _gains(record, record.rows(found), places, with_steps.noise))
    z = z[z > 0.0]
    scales = np.geomspace(0.3, 1.5, 15) * float(np.sqrt(np.mean(z**2)))
    tried = [_tail(z, freedom, scales) for freedom in FREEDOMS]
    weights = np.exp(np.array([one for one, _ in tried]) - max(one for one, _ in tried))
    p_values = [
        2.0 * student_upper_p(size / scale, freedom)
        for freedom, (_, scale) in zip(FREEDOMS, tried, strict=True)
    ]
    return float(weights @ p_values / weights.sum()) * places.size


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
