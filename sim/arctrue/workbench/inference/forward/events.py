"""Searches a record for steps, which are events that no other part of the record repeats.

No block of a record can predict an event that occurs in another block only. A step is therefore
tested by its likelihood alone and is not named as a cause: it is reported as a jump.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.record import Record
from arctrue.workbench.inference.forward.tests_of_a_line import FAMILY_WISE, needed_gain
from arctrue.workbench.noise.kernel import KernelNoise
from arctrue.workbench.noise.kernel_fit import KernelFit, Rows, best_fit, usual_starts
from arctrue.workbench.noise.level import noise_level
from arctrue.workbench.numeric.distributions import student_log_density, student_upper_p

Float = NDArray[np.float64]

ONE_BY_ONE = 16
"""Largest number of steps each of which is searched with the noise estimated anew. Further steps
are searched many at a time, to limit the computing time."""
MOST_STEPS = 64
"""Largest number of steps that the search returns; it only limits the computing time. If there are
more than ONE_BY_ONE steps, the report states "at least" this number."""
LEAST_SIDE_ROWS = 5
"""Smallest number of rows between a step and either end of its stretch (successive rows without a
break)."""
MOST_SHARES = 8
"""Largest number of readings of one mean that are tried as the first reading after a step. A step
is then too small by at most 1/16 of the weight of one mean."""
ROUNDING = 1e-6
"""The stated time of a step is earlier than the first reading after it by this share of the
interval between two readings, so that this reading comes after the step in spite of rounding."""
COVERAGE = 2.0
"""Factor of the standard uncertainty of a step's size, for a coverage of 95 %."""
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

    def may_be_one(self, display_step_arcsec: float) -> bool:
        """Tell whether the readings may have jumped by one step of the display, which a slow change
        causes too; False for a display without steps (0)."""
        least = abs(self.size_arcsec) - COVERAGE * self.sigma_arcsec
        return display_step_arcsec > 0.0 and least <= display_step_arcsec

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
    therefore tested with all steps in the model, and the steps that they explain are removed until
    they explain none.
    """
    places = _inside(record)
    rows: list[int] = []
    grown = fit
    while len(rows) < ONE_BY_ONE:
        step = _next_step(record, _with_steps(record, lines, rows), places, grown)
        if step is None:
            break
        rows.append(step[0])
        grown = step[1]
    while ONE_BY_ONE <= len(rows) < MOST_STEPS:
        at = _within_their_rows(record, lines, rows, grown.noise)
        others = _with_shares(record, lines, at)
        further = _further_steps(record, others, [*rows, *(row for row, _ in at)], places, grown)
        if not further:
            break
        rows = [*rows, *further][:MOST_STEPS]
        left = record.rows(_with_steps(record, lines, rows))
        grown = best_fit(left, [grown.noise, *usual_starts(left)])
    while rows:
        joint = _Joint(record, lines, rows, fit, grown)
        wrong = _explained_by_noise(joint, places)
        if not wrong:
            return _sized(joint)
        rows = [row for row in rows if row not in wrong]
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
        if best is not None and row == best[1]:
            continue
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


def _further_steps(
    record: Record,
    others: Float,
    rows: Sequence[int],
    places: NDArray[np.int64],
    without: KernelFit,
) -> list[int]:
    """Return the rows of all steps that are significant in this noise, each with those before it in
    the model; ``others`` are the columns of the lines and of the steps at ``rows``.

    A step within a mean looks like two steps that are at most two rows apart, until its share of
    the mean is in the model.
    """
    found: list[int] = []
    noise = without.noise
    own, columns = _left_by(record.rows(others), _steps_at(record, places), noise)
    free = np.min(np.abs(places[:, np.newaxis] - np.array(rows)), axis=1) > 1
    while free.any():
        gains = np.where(free, _rises_of(own, columns), 0.0)
        at = int(np.argmax(gains))
        gain, row = float(gains[at]), int(places[at])
        if record.of_few_rows(gain) <= needed_gain(gain, float(places.size)):
            break
        free &= np.abs(places - row) > 2
        with_found = record.rows(_with_steps(record, others, found))
        wrong_rows = np.zeros((record.clock.size, 2))
        wrong_rows[[row - 1, row], [0, 1]] = 1.0
        if float(np.max(_rises(with_found, wrong_rows, noise))) >= gain:
            continue
        found.append(row)
        unit = columns[:, at] / np.linalg.norm(columns[:, at])
        own = own - unit * float(unit @ own)
        columns = columns - np.outer(unit, unit @ columns)
    return found


@dataclass(frozen=True, eq=False)
class _Joint:
    """All steps of a record, which are fitted together."""

    record: Record
    lines: Float
    """Columns of the lines."""
    rows: Sequence[int]
    """Rows of the steps."""
    without_all: KernelFit
    """The noise without steps in the model."""
    with_all: KernelFit
    """The noise with all steps in the model."""
    _without: dict[int, KernelFit] = field(default_factory=dict)
    """The fits of :meth:`without` that were made."""

    def others(self, row: int) -> Float:
        """Return the columns of the lines and of all steps except that at ``row``."""
        return _with_steps(self.record, self.lines, [item for item in self.rows if item != row])

    def without(self, row: int) -> KernelFit:
        """Return the noise with all steps except that at ``row``; with more than ONE_BY_ONE steps,
        the noise with all steps, and the likelihood of this noise without this step."""
        if len(self.rows) == 1:
            return self.without_all
        if len(self.rows) > ONE_BY_ONE:
            left, noise = self.record.rows(self.others(row)), self.with_all.noise
            rise = float(_rises(left, step_column(self.record, row), noise)[0])
            return KernelFit(noise, self.with_all.log_likelihood - rise)
        if row not in self._without:
            left = self.record.rows(self.others(row))
            starts = [self.without_all.noise, self.with_all.noise, *usual_starts(left)]
            self._without[row] = best_fit(left, starts)
        return self._without[row]


def _explained_by_noise(joint: _Joint, places: NDArray[np.int64]) -> list[int]:
    """Return the rows of the steps that the tails of the noise explain, or the row of the first
    step that a changing level explains; an empty list if the noise explains no step.

    Of two neighbouring steps, only the one that the tails explain better is returned, because its
    removal makes the other one larger.
    """
    found = _p_of_tails(joint, places)
    order = np.argsort(joint.rows)
    wrong: list[int] = []
    for number in np.argsort(-found, kind="stable"):
        at = int(np.flatnonzero(order == number)[0])
        neighbours = {joint.rows[other] for other in order[max(at - 1, 0) : at + 2]}
        if found[number] > FAMILY_WISE * OF_TAILS and not neighbours & set(wrong):
            wrong.append(joint.rows[int(number)])
    if wrong:
        return wrong
    return next(([row] for row in joint.rows if _level_makes_it(joint, row, places)), [])


def _sized(joint: _Joint) -> list[Step]:
    """Return the steps with their sizes, which are fitted together."""
    record, lines, rows = joint.record, joint.lines, joint.rows
    at = [(row, 1.0) for row in rows]
    fit = joint.with_all
    if np.any(record.readings > 1.0):
        at = _within_their_rows(record, lines, rows, fit.noise)
        left = record.rows(_with_shares(record, lines, at))
        fit = best_fit(left, [fit.noise, *usual_starts(left)])
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
        gain = joint.with_all.score - joint.without(rows[number]).score
        where = float(record.place[row])
        steps.append(Step(row, where, float(sizes[number]), float(sigma), gain, share))
    return steps


def _with_shares(record: Record, lines: Float, at: Sequence[tuple[int, float]]) -> Float:
    """Return the columns of the lines and of steps, each with its row and its share of this row."""
    return np.hstack([lines, *(step_column(record, row, share) for row, share in at)])


def _within_their_rows(
    record: Record, lines: Float, rows: Sequence[int], noise: KernelNoise
) -> list[tuple[int, float]]:
    """Return row and share of each step at its most likely reading, among the readings that are
    averaged in its row and in the row before. Otherwise a step in the middle of a mean would seem
    too small."""
    at = [(row, 1.0) for row in rows]
    for number, row in enumerate(rows):
        places = [(row, float(share)) for share in _shares(record.readings[row])]
        if record.stretch[row - 1] == record.stretch[row]:
            before = _shares(record.readings[row - 1])[:-1]
            places += [(row - 1, float(share)) for share in before]
        others = [item for other, item in enumerate(at) if other != number]
        tried = record.rows(_with_shares(record, lines, others))
        columns = np.hstack([step_column(record, *place) for place in places])
        at[number] = places[int(np.argmax(_rises(tried, columns, noise)))]
    return at


def _shares(readings: float) -> Float:
    """Return the tried shares of a mean's readings after a step, the whole mean last."""
    count = round(float(readings))
    return np.unique(np.ceil(np.linspace(1, count, min(count, MOST_SHARES)))) / count


def _inside(record: Record) -> NDArray[np.int64]:
    """Return the rows at which a step has enough rows of its stretch on both sides and is not
    explained by the base."""
    found = []
    for number in np.unique(record.stretch):
        own = np.flatnonzero(record.stretch == number)
        found.append(own[LEAST_SIDE_ROWS : own.size - LEAST_SIDE_ROWS + 1])
    rows = np.concatenate(found).astype(np.int64)
    return rows[_own_shares(record, rows) > LEAST_OWN]


LEAST_OWN = 1e-3
"""Smallest share of a step's sum of squares about its mean that the base must leave; the step's u
is then at most 32 times that without the base (1/√0.001). The base may contain a step: over
successive passes, the difference of time and angle has a step at each start of a pass."""


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
    return _rises(rows, _steps_at(record, places), noise)


def _steps_at(record: Record, places: NDArray[np.int64]) -> Float:
    """Return the columns of steps at each of the rows ``places``."""
    number = np.arange(record.clock.size)[:, np.newaxis]
    same = record.stretch[:, np.newaxis] == record.stretch[places]
    return np.asarray((number >= places) & same, dtype=np.float64)


def _rises(rows: Rows, columns: Float, noise: KernelNoise) -> Float:
    """Return the rise of the log likelihood by each of the columns, with the noise unchanged."""
    own, left = _left_by(rows, columns, noise)
    return _rises_of(own, left)


def _rises_of(own: Float, columns: Float) -> Float:
    """Return half of the square that each column takes from ``own``; 0 for a column without size.
    Both are whitened and without their fit by the model."""
    square = np.einsum("ij,ij->j", columns, columns)
    found = np.zeros(square.size)
    np.divide(0.5 * (columns.T @ own) ** 2, square, out=found, where=square > 1e-9)
    return found


def _left_by(rows: Rows, columns: Float, noise: KernelNoise) -> tuple[Float, Float]:
    """Return the whitened rows and columns, both without their fit by the columns of the rows."""
    factor = rows.factor(noise)
    whitened = factor.whiten(rows.values)
    vectors, values, _ = np.linalg.svd(whitened[:, 1:], full_matrices=False)
    model = vectors[:, values > 1e-9 * values[0]]
    own = whitened[:, 0] - model @ (model.T @ whitened[:, 0])
    columns = factor.whiten(columns)
    return own, columns - model @ (model.T @ columns)


def _one_row_does_it(
    record: Record, others: Float, row: int, gain: float, without: KernelFit, grown: KernelFit
) -> bool:
    """Tell whether a single wrong row explains the rows as well as the step does: the first row
    after the step or the last row before it."""
    for wrong in (row - 1, row):
        column = np.zeros((record.clock.size, 1))
        column[wrong] = 1.0
        with_step = record.rows(np.hstack([others, column]))
        rival = best_fit(with_step, [without.noise, grown.noise])
        if rival.score - without.score >= gain:
            return True
    return False


def _p_of_tails(joint: _Joint, places: NDArray[np.int64]) -> Float:
    """Return, for each step, the probability that the tails of the noise give a step of its size
    somewhere in the record; 0 if many innovations determine the step.

    In a random walk each innovation is a step, so that the gains of steps at all other instants
    have the same tails as the innovations. Student's t is fitted to the square roots of twice these
    gains, with all steps in the model, and each of FREEDOMS is weighted with its likelihood.
    """
    record, noise = joint.record, joint.with_all.noise
    factor = record.rows().factor(noise)
    columns = factor.whiten(np.hstack([step_column(record, row) for row in joint.rows])) ** 2
    few = columns.max(axis=0) >= FEW * columns.sum(axis=0)
    found = np.zeros(len(joint.rows))
    if not few.any():
        return found
    with_all = record.rows(_with_steps(record, joint.lines, joint.rows))
    z = np.sqrt(2.0 * _gains(record, with_all, places, noise))
    z = z[z > 0.0]
    scales = np.geomspace(0.3, 1.5, 15) * float(np.sqrt(np.mean(z**2)))
    tried = [_tail(z, freedom, scales) for freedom in FREEDOMS]
    weights = np.exp(np.array([one for one, _ in tried]) - max(one for one, _ in tried))
    for number in np.flatnonzero(few):
        row = joint.rows[int(number)]
        here = _gains(record, record.rows(joint.others(row)), np.array([row]), noise)
        size = float(np.sqrt(2.0 * here[0]))
        p_values = [
            2.0 * student_upper_p(size / scale, freedom)
            for freedom, (_, scale) in zip(FREEDOMS, tried, strict=True)
        ]
        found[number] = float(weights @ p_values / weights.sum()) * places.size
    return found


def _level_makes_it(joint: _Joint, row: int, places: NDArray[np.int64]) -> bool:
    """Tell whether the step is not significant in noise whose level changes with time.

    The innovations, and the whitened columns of model and step, are divided by the local level of
    the innovations that remain with the step in the model. The gain must then reach the limit for
    all rows in ``places``, with the noise estimated with the step and without it.
    """
    rows = joint.record.rows(np.hstack([joint.others(row), step_column(joint.record, row)]))
    if _level_with(rows, joint.with_all.noise, places.size):
        return True
    without = joint.without(row).noise
    return without is not joint.with_all.noise and _level_with(rows, without, places.size)


def _level_with(rows: Rows, noise: KernelNoise, places: int) -> bool:
    """Return True if the level of the innovations in this noise changes with time and, at this
    level, the last column of the rows (a step) is not significant among ``places`` places."""
    whitened = rows.factor(noise).whiten(rows.values)
    own, columns = whitened[:, 0], whitened[:, 1:]
    level = noise_level(own - columns @ np.linalg.lstsq(columns, own, rcond=1e-10)[0])
    if level is None:
        return False
    own, columns = own / level.local, columns / level.local[:, np.newaxis]
    squares = [
        float(np.sum((own - used @ np.linalg.lstsq(used, own, rcond=1e-10)[0]) ** 2))
        for used in (columns[:, :-1], columns)
    ]
    free = max(own.size - columns.shape[1], 1)
    gain = 0.5 * own.size * float(np.log(squares[0] / squares[1])) * free / own.size
    return bool(gain <= np.log(places / FAMILY_WISE))


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
the tails. At this share, more than fourteen innovations contribute to the step, and their heavy
tails average out."""
