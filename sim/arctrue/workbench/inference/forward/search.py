"""Adds one line (a sinusoidal error) after another to the model of a record, and orders the lines
by the error that they remove.

Each step scans all rates twice: with the noise that is estimated without a further line, and with
white noise alone. White noise is needed because the estimated noise completely absorbs a line far
above the scatter of neighbouring rows. The rates with the highest gains, called places, are then
tested; for each, the noise is estimated anew without and with the line.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.events import Step, columns_of_steps, search_steps
from arctrue.workbench.inference.forward.pairs import Pair, pair_of
from arctrue.workbench.inference.forward.record import Record, orthonormal
from arctrue.workbench.inference.forward.tests_of_a_line import (
    FAMILY_WISE,
    Coherence,
    coherence,
    gain_over_an_oscillator,
    nearest,
    needed_gain,
    periods_in,
)
from arctrue.workbench.noise.kernel import KernelNoise
from arctrue.workbench.noise.kernel_fit import (
    KernelFit,
    Rows,
    best_fit,
    best_of,
    fit_from,
    usual_starts,
    with_oscillator,
)
from arctrue.workbench.noise.level import noise_level
from arctrue.workbench.noise.whiteness import whiteness

Float = NDArray[np.float64]

LEAST_PERIODS, DECLARED_PERIODS = 4.0, 3.0
"""Fewest periods of a line in a record. A line with fewer periods counts as a slow change of
unknown form; 3 periods are enough if the set states the period."""
TRIED = 3
"""Number of places of each scan, those with the highest gains, that are tested further."""
OVERSAMPLED = 3.0
"""Number of rates per 1/span in a scan: a line midway between two rates keeps 91 % of its gain,
sinc²(1/6)."""
APART = 1.5
"""A place of a scan counts as a side lobe of a higher place if it is nearer to it than this, in
units of 1/span."""
MOST_LINES = 16
"""Largest number of lines, to limit cost: about three times the number of lines, five, in the
benchmark's record with the most lines.
"""
MOST_MULTIPLE = 8
"""Highest multiple of a declared rate that is searched."""
OSCILLATOR_GAIN = 7.0
"""Smallest gain in log likelihood of a line over an oscillator at its frequency. In 24 simulated
records of a resonance that keeps its phase for a sixth of the record, 65 places pass all other
tests, and no place gains more (``python -m scripts.calibrate_line_search --logs 24 --kinds Q
--oscillator``). In other noise, no place passes the other tests, or a place that passes them gains
at most 5.1."""
PREDICTED_SHARE = 0.5
"""Smallest share of a line's own error that the other blocks must predict."""
NOT_WHITE = 1e-4
"""If p of Ljung and Box is below this value, an oscillator is added to the noise before the search
for a line."""
BELOW, NEXT_TO_THE_MODEL = 3, 3.0
"""Limits for a line just above the orders of a model. If fewer than BELOW ordinates of the spectrum
below the line are free of the model's orders, the gain of the line must be NEXT_TO_THE_MODEL times
the usual limit. Slow noise, of which the model has absorbed a part, looks like such a line, with a
gain of at most 2 times the limit. None of 576 simulated records of noise shows a line (``python -m
scripts.calibrate_line_search --orders --logs 4``)."""
COLUMNS_TOGETHER = 400
"""Largest number of columns of one matrix product; it limits memory only."""


@dataclass(frozen=True)
class Line:
    """One regular line that passed every test."""

    rate: float
    """Rate in periods per turn, or in Hz."""
    amplitude_arcsec: float
    phase_rad: float
    """Phase of the line's cosine at the first row."""
    taken_arcsec: float
    """RMS over all rows of the error that the line's prediction from other blocks removes."""
    share: float
    """Share of the line's own error that the other blocks predict; 1 for a record of one turn,
    which cannot show this share."""
    gain: float
    """Rise of the log likelihood when the line was added, with the noise estimated without and with
    it; this rise is multiplied by :func:`own_shares` and divided by the local level of the noise.
    """
    oscillator_gain: float
    periods: float
    independent: float
    """Number of independent rates among which the line was found."""
    multiple: int | None = None
    """Multiple of the declared rate; None if the line is not one of its multiples."""


@dataclass(frozen=True)
class Rejected:
    """A place with a high gain that did not pass a test."""

    rate: float
    gain: float
    why: str


@dataclass(frozen=True, eq=False)
class LineSearch:
    """Result of the forward search in one record."""

    record: Record
    lines: tuple[Line, ...]
    """Lines, ordered by the error that they remove, the largest first."""
    noise: KernelFit
    """Noise with all lines in the model."""
    whiteness_p: float
    """p of Ljung and Box for the whitened residuals with all lines and steps in the model."""
    steps: tuple[Step, ...] = ()
    """Single jumps, in the order in which they were found."""
    rejected: tuple[Rejected, ...] = field(default=(), repr=False)
    """Rejected places of the last step."""


@dataclass(frozen=True, eq=False)
class _Tried:
    rate: float
    gain: float
    oscillator_gain: float
    fit: KernelFit
    why: str | None


def search_record(record: Record, display_step_arcsec: float = 0.0) -> LineSearch:
    """Search lines, then steps with the lines in the model. If there are steps, search the lines
    again with the steps in the model.

    A display that rounds to ``display_step_arcsec`` (0 for none) jumps by this step where the error
    changes slowly. Such jumps are no events and are not returned. Together they can follow a line,
    so that the line would vanish with them in the model: the lines are searched without them. The
    whiteness of the residuals is that with these jumps or without them, whichever is higher,
    because the rounding error is not white.
    """
    found = search_lines(record)
    lines = record.columns(np.array([line.rate for line in found.lines]))
    steps = search_steps(record, lines, found.noise)
    events = [step for step in steps if not step.may_be_one(display_step_arcsec)]
    if events:
        found = search_lines(_with_steps(record, events))
    if len(events) < len(steps):
        lines = record.columns(np.array([line.rate for line in found.lines]))
        with_all = _with_steps(record, steps)
        white = whiteness_of(with_all.rows(lines), noise_with(with_all, lines).noise)
        found = replace(found, whiteness_p=max(found.whiteness_p, white))
    return replace(found, steps=tuple(events))


def _with_steps(record: Record, steps: Sequence[Step]) -> Record:
    """Return the record with the steps in its base."""
    return replace(record, base=orthonormal([record.base, columns_of_steps(record, steps)]))


def search_lines(record: Record, *, oscillator_gain: float = OSCILLATOR_GAIN) -> LineSearch:
    """Return every line that the record shows; test rejected places again after each addition.

    ``oscillator_gain`` is a parameter only for its calibration.
    """
    rates: list[float] = []
    found: list[_Tried] = []
    noise: KernelNoise | None = None
    rejected: list[Rejected] = []
    incoherent: list[_Tried] = []
    while True:
        others = record.columns(np.array(rates))
        without = noise_with(record, others, noise)
        if len(rates) >= MOST_LINES:
            break
        level = level_of(record.rows(others), without.noise)
        tried = [
            _tried(record, rate, rates, without, level)
            for rate in _places(record, rates, without, level)
        ]
        best, rejected, incoherent = None, [], []
        for item in sorted(tried, key=lambda item: -item.gain):
            judged = item
            if item.why is None:
                judged = _judged(record, item, others, without, level, oscillator_gain)
            if judged.why is None:
                best = judged
                break
            rejected.append(Rejected(judged.rate, judged.gain, judged.why))
            if item.why is None:
                incoherent.append(item)
        if best is None:
            pair = _pair(record, incoherent, rates, without, level, oscillator_gain)
            if not pair or len(rates) + len(pair) > MOST_LINES:
                break
            found += pair
            rates = _moved(record, [*rates, *(one.rate for one in pair)], pair[-1].fit.noise)
            noise = pair[-1].fit.noise
            continue
        found.append(best)
        rates.append(best.rate)
        rates = _moved(record, rates, best.fit.noise)
        noise = best.fit.noise
    record.forget()
    return _ordered(record, rates, found, without, rejected)


def noise_with(record: Record, others: Float, near: KernelNoise | None = None) -> KernelFit:
    """Estimate the noise with ``others`` in the model, and with an oscillator if the residuals are
    not white."""
    rows = record.rows(others)
    starts = usual_starts(rows)
    if near is not None:
        starts.append(near.without_oscillators())
    fits = [fit_from(rows, start) for start in starts]
    found = best_of(fits)
    if whiteness_of(rows, found.noise) >= NOT_WHITE:
        return found
    wider = best_fit(rows, _with_resonance(rows, fits))
    # Variance, decay and frequency must each gain half a logarithm of the number of rows.
    worth = 1.5 * float(np.log(rows.clock.size))
    return wider if wider.score > found.score + worth else found


def _with_resonance(rows: Rows, fits: Iterable[KernelFit]) -> Iterator[KernelNoise]:
    """Yield each noise with one more oscillator, at the peak of its local level (`level_of`)."""
    variance = max(float(np.mean(rows.left() ** 2)) / 10.0, 1e-30)
    for fit in fits:
        noise = fit.noise
        if noise.smooth:
            # The exponential parts are omitted, because exact derivatives exist for few columns
            # only.
            parts = tuple(part for part in noise.parts if part.kind == "smooth")
            noise = KernelNoise(noise.white, parts)
        level = level_of(rows, fit.noise)
        frequency = float(level.frequency[int(np.argmax(level.excess))])
        yield with_oscillator(noise, rows, frequency, variance)


def whiteness_of(rows: Rows, noise: KernelNoise) -> float:
    """Return p of Ljung and Box for the whitened residuals.

    If their level changes with time, residuals and columns are divided by the local level.
    """
    left, columns = _whitened(rows, noise)
    found = whiteness(left, columns)
    if found is not None and found.autocorrelation_p < FAMILY_WISE:
        level = noise_level(left)
        if level is not None:
            found = whiteness(left / level.local, columns / level.local[:, np.newaxis])
    return 1.0 if found is None else found.autocorrelation_p


def whitened_left(rows: Rows, noise: KernelNoise) -> Float:
    """Return the whitened residuals of the rows' columns."""
    return _whitened(rows, noise)[0]


def _whitened(rows: Rows, noise: KernelNoise) -> tuple[Float, Float]:
    """Return the whitened residuals of the rows' columns, and the whitened columns."""
    whitened = rows.factor(noise).whiten(rows.values)
    own, columns = whitened[:, 0], whitened[:, 1:]
    return own - columns @ np.linalg.lstsq(columns, own, rcond=1e-10)[0], columns


@dataclass(frozen=True, eq=False)
class Level:
    """Local level of the noise: power of whitened residuals, divided by that of white noise."""

    frequency: Float
    """Frequencies, periods per unit of the clock."""
    excess: Float
    """Power ratio around each frequency; at least 1."""

    def at(self, record: Record, rate: float) -> float:
        """Return the factor by which the gain of a line at this rate is divided."""
        return float(np.interp(record.on_the_clock(rate), self.frequency, self.excess))

    def below(self, record: Record, rate: float) -> int:
        """Return the number of usable ordinates at frequencies below a rate."""
        return int(np.count_nonzero(self.frequency < record.on_the_clock(rate)))


def level_of(rows: Rows, noise: KernelNoise) -> Level:
    """Measure the local level of the noise; it is needed because a sum of noise parts cannot follow
    every shape of a spectrum.

    The level is the median of the periodogram of the whitened residuals over NEIGHBOURS ordinates,
    divided by the median for white noise, ln 2: a single line among them hardly changes the median.
    """
    left = whitened_left(rows, noise)
    power = np.abs(np.fft.rfft(left))[1:] ** 2 / left.size
    # A model of many orders absorbs the power at the frequencies of these orders: those ordinates
    # do not show the noise.
    shown = _shares_shown(rows) > HALF_SHOWN
    shown = shown if np.count_nonzero(shown) >= 3 else np.ones(power.size, dtype=bool)
    power = power[shown]
    wide = min(NEIGHBOURS, power.size // 2 * 2 - 1)
    edges = np.pad(power, wide // 2, mode="reflect")
    middle = np.median(np.lib.stride_tricks.sliding_window_view(edges, wide), axis=-1)
    frequency = np.arange(1, shown.size + 1)[shown] / (left.size * rows.step)
    return Level(frequency, np.maximum(middle / np.log(2.0), 1.0))


def _shares_shown(rows: Rows) -> Float:
    """Return the share of each periodogram ordinate that the columns of the rows leave.

    Shape (rows // 2,). The columns need not be orthonormal.
    """
    columns = orthonormal([rows.values[:, 1:]])
    taken = np.sum(np.abs(np.fft.rfft(columns, axis=0)[1:]) ** 2, axis=1) / columns.shape[0]
    # Normalised cosine and sine of one ordinate contribute half a unit each: together 1.
    return np.asarray(1.0 - np.minimum(taken, 1.0))


HALF_SHOWN = 0.5
"""An ordinate of the spectrum is used for the level if the columns of the model leave more than
this share of it."""
NEIGHBOURS = 41
"""Number of ordinates in the median, which scatters by a sixth (1/√41)."""


def _places(
    record: Record, rates: Sequence[float], without: KernelFit, level: Level
) -> Iterator[float]:
    """Yield the rates with the highest gains in the estimated noise or in white noise."""
    others = record.columns(np.array(rates))
    rows = record.rows(others)
    white = KernelNoise(max(float(np.mean(rows.left() ** 2 * rows.readings)), 1e-30))
    grid = _grid(record)
    multiples = _multiples(record)
    kept: list[float] = []
    for noise in (without.noise, white):
        gains = scan(record, grid, others, noise)
        gains[_near(grid, rates, record)] = 0.0
        of_multiples = scan(record, multiples, others, noise)
        of_multiples[_near(multiples, rates, record)] = 0.0
        places = [*_highest(grid, gains, record), *_highest(multiples, of_multiples, record)]
        for rate in places:
            moved = rate
            if not record.whole_orders_only:
                moved = _refined(record, rate, others, noise)
            if nearest([*rates, *kept], moved) * record.span >= SAME_PLACE:
                kept.append(moved)
    for rate in kept:
        if nearest(rates, rate) * record.span < 1.0:
            continue
        gain = float(scan(record, np.array([rate]), others, without.noise)[0])
        least = LITTLE * _needed(record, rate, gain) * level.at(record, rate)
        if gain > least or _takes_much(record, others, record.line_columns(rate)):
            yield rate


LITTLE = 0.5
"""A rate is tested if its gain in the scan exceeds this share of the needed gain; a new estimate of
the noise does not raise a smaller gain to the limit."""
SAME_PLACE = 0.1
"""Two scans have found the same line if their rates differ by less than this, in units of
1/span."""


def _grid(record: Record) -> Float:
    lowest = LEAST_PERIODS / record.span
    lowest = max(lowest, 1.0 / record.longest)
    if record.whole_orders_only:
        return np.arange(np.ceil(lowest), np.floor(record.highest) + 1.0)
    count = max(int((record.highest - lowest) * record.span * OVERSAMPLED), 1)
    return np.linspace(lowest, record.highest, count)


def _multiples(record: Record) -> Float:
    if record.declared is None:
        return np.zeros(0)
    found = record.declared * np.arange(1, MOST_MULTIPLE + 1)
    lowest = max(DECLARED_PERIODS / record.span, 1.0 / record.longest)
    return np.asarray(found[(found >= lowest) & (found <= record.highest)])


def _near(grid: Float, rates: Sequence[float], record: Record) -> NDArray[np.bool_]:
    found = np.zeros(grid.size, dtype=bool)
    for rate in rates:
        found |= np.abs(grid - rate) * record.span < 1.0
    return found


def scan(record: Record, rates: Float, others: Float, noise: KernelNoise) -> Float:
    """Return the rise of the log likelihood by a line at each rate, with the noise unchanged.

    The rise is multiplied by the line's share from :func:`own_shares`; shape (rates,).
    """
    found = np.zeros(rates.size)
    if rates.size == 0:
        return found
    rows = record.rows(others)
    factor = rows.factor(noise)
    whitened = factor.whiten(rows.values)
    vectors, values, _ = np.linalg.svd(whitened[:, 1:], full_matrices=False)
    model = vectors[:, values > 1e-9 * values[0]]
    own = whitened[:, 0] - model @ (model.T @ whitened[:, 0])
    together = COLUMNS_TOGETHER // 2
    for start in range(0, rates.size, together):
        part = slice(start, start + together)
        measured = record.columns(rates[part])
        columns = factor.whiten(measured)
        before = np.einsum("ij,ij->j", columns, columns)
        columns -= model @ (model.T @ columns)
        cosine, sine = columns[:, 0::2], columns[:, 1::2]
        cc, ss, cs = (
            np.einsum("ij,ij->j", left, right)
            for left, right in ((cosine, cosine), (sine, sine), (cosine, sine))
        )
        c, s = cosine.T @ own, sine.T @ own
        determinant = cc * ss - cs**2
        there = determinant > OWN_SHARE * before[0::2] * before[1::2]
        square = c**2 * ss - 2.0 * c * s * cs + s**2 * cc
        np.divide(0.5 * square, determinant, out=found[part], where=there)
        found[part] *= own_shares(record, measured)
    return found


OWN_SHARE = 1e-3
"""Smallest share of the squares of a line's columns that the base does not explain; with a smaller
share, the line belongs to the base."""


def _highest(grid: Float, gains: Float, record: Record) -> list[float]:
    """Return the places with the highest gains, without the neighbours of a higher place."""
    left = gains.copy()
    found: list[float] = []
    while len(found) < TRIED and left.size and float(left.max()) > 0.0:
        at = int(np.argmax(left))
        found.append(float(grid[at]))
        left[np.abs(grid - grid[at]) * record.span < APART] = 0.0
    return found


def _refined(record: Record, rate: float, others: Float, noise: KernelNoise) -> float:
    """Return the rate with the highest gain, at most half of 1/span from the given rate.

    The steps become finer than the uncertainty of the rate, which is 0.55/(span·√(2·gain)) for a
    line over the whole record. If the rate of a large line were not exact, other effects would
    explain the remaining error.
    """
    wide = 0.5 / record.span
    for number in range(MOST_REFINED):
        grid = rate + np.linspace(-wide, wide, 11)
        gains = scan(record, grid, others, noise)
        at = int(np.argmax(gains))
        rate = float(grid[at])
        wide /= 5.0
        sigma = 0.55 / (record.span * np.sqrt(2.0 * max(float(gains[at]), 1.0)))
        if number > 0 and wide < FINE * sigma:
            break
    return rate


MOST_REFINED = 8
"""Largest number of refinements of a rate; the last step is 10⁻⁶ of 1/span."""
FINE = 0.25
"""Step of the last refinement, in uncertainties of the rate: an error of half a step loses 1/128 of
a log likelihood."""


def _moved(record: Record, rates: Sequence[float], noise: KernelNoise) -> list[float]:
    """Move each line in turn to the rate with the highest gain, with all other lines in the
    model."""
    if record.whole_orders_only:
        return list(rates)
    found = list(rates)
    for at, rate in enumerate(rates):
        others = record.columns(np.array(found[:at] + found[at + 1 :]))
        found[at] = _refined(record, rate, others, noise)
    return found


def _takes_much(record: Record, others: Float, line: Float) -> bool:
    before = record.rows(others).left()
    after = record.rows(np.hstack([others, line])).left()
    return float(after @ after) < (1.0 - MUCH) * float(before @ before)


MUCH = 0.05
"""If a line removes more than this share of the residuals' sum of squares, the search for the noise
also begins at the usual starts."""


def _nearest_multiple(record: Record, rate: float) -> int | None:
    """Return the factor of the multiple of the declared rate that this rate is near, within the
    resolution of the record; None if there is no such multiple."""
    if record.declared is None:
        return None
    times = round(rate / record.declared)
    near = abs(rate - times * record.declared) * record.span
    return times if 1 <= times <= MOST_MULTIPLE and near < 0.5 else None


def _multiples_of(record: Record, rates: Sequence[float], noise: KernelNoise) -> list[int | None]:
    """Return, for each line, the factor by which it is a multiple of the declared rate; None if it
    is no multiple.

    A line at the multiple must explain the error as well as the line at its own rate, with all
    other lines in the model. If the record can show the declared rate itself and contains no line
    there, the multiples need closer agreement: a gear usually has its own rate too.
    """
    near = [_nearest_multiple(record, rate) for rate in rates]
    penalty = float(np.log(record.clock.size))
    lost: list[float] = []
    found: list[int | None] = []
    for rate, times in zip(rates, near, strict=True):
        if times is None or record.declared is None:
            lost.append(float("inf"))
            found.append(None)
            continue
        others = record.columns(np.array([other for other in rates if other != rate]))
        gains = scan(record, np.array([rate, times * record.declared]), others, noise)
        lost.append(2.0 * float(gains[0] - gains[1]))
        most = max(penalty + AS_GOOD, 2.0 * MODULATED * float(gains[0]))
        found.append(times if lost[-1] < most else None)
    own = record.declared is None or periods_in(record, record.declared) < DECLARED_PERIODS
    if own or 1 in found:
        return found
    return [times if lost[at] < penalty else None for at, times in enumerate(found)]


AS_GOOD = 6.0
"""BIC advantage that a line of its own rate needs over a line at a multiple of the declared rate:
odds of 20 to 1. The own rate is one parameter more."""
MODULATED = 0.01
"""Share of a line's gain that the line at the multiple may lose in any case: a gear whose phase
wanders by 0.2 rad RMS loses 0.2²/4 = 1 % by one wrong rate."""


def _needed(record: Record, rate: float, gain: float) -> float:
    declared = _nearest_multiple(record, rate) is not None
    independent = float(_multiples(record).size) if declared else record.independent
    return needed_gain(gain, max(independent, 1.0))


def _tried(
    record: Record, rate: float, rates: Sequence[float], without: KernelFit, level: Level
) -> _Tried:
    """Return the gain of a line; the noise is estimated anew with the line in the model."""
    others = record.columns(np.array(rates))
    line = record.line_columns(rate)
    rows = record.rows(np.hstack([others, line]))
    starts = [without.noise]
    if _takes_much(record, others, line):
        # A large line changes the noise so much that the noise without the line is a poor start.
        starts += usual_starts(rows)
    grown = best_fit(rows, starts)
    if not record.whole_orders_only:
        moved = _refined(record, rate, others, grown.noise)
        if nearest(rates, moved) * record.span >= 1.0:
            rate, line = moved, record.line_columns(moved)
            grown = fit_from(record.rows(np.hstack([others, line])), grown.noise)
    gain = record.of_few_rows(grown.score - without.score) * float(own_shares(record, line)[0])
    gain /= level.at(record, rate)
    declared = _nearest_multiple(record, rate) is not None
    tried = _Tried(rate, gain, 0.0, grown, None)
    needed = _needed(record, rate, gain)
    if gain <= needed:
        return replace(tried, why=f"gains {gain:.1f} of {needed:.1f}")
    periods = periods_in(record, rate)
    if periods < (DECLARED_PERIODS if declared else LEAST_PERIODS):
        return replace(tried, why=f"{periods:.1f} periods")
    return tried


def own_shares(record: Record, columns: Float) -> Float:
    """Return the share of the squares of each line's columns that the base leaves; shape (lines,).

    A gain is multiplied by this share. If the base explains a part of a line, it has also absorbed
    that part of the noise, so that the noise is known less well. Without this factor, the part of a
    slow change that the base leaves would look like lines next to the table's orders, if the record
    is shorter than a turn. These lines would cancel the orders.
    """
    pairs = (-1, 2)
    made = np.sum((record.base.T @ columns) ** 2, axis=0).reshape(pairs).sum(axis=1)
    whole = np.sum(columns**2, axis=0).reshape(pairs).sum(axis=1)
    return np.asarray(np.maximum(1.0 - made / np.maximum(whole, 1e-300), 0.0))


def _judged(
    record: Record,
    tried: _Tried,
    others: Float,
    without: KernelFit,
    level: Level,
    oscillator_gain: float,
) -> _Tried:
    """Test whether the line is the same in all blocks, and more than an oscillator driven by noise.

    Return the place with the results of the tests; ``why`` is the reason if it fails one of them,
    otherwise None.
    """
    if record.whole_orders_only:
        # Neighbouring orders cannot be separated on one turn, so that neither test applies.
        return tried
    needed = NEXT_TO_THE_MODEL * _needed(record, tried.rate, tried.gain)
    if tried.gain < needed and level.below(record, tried.rate) < BELOW:
        return replace(tried, why=f"gains {tried.gain:.1f} of {needed:.1f} next to the model")
    rate, line = tried.rate, record.line_columns(tried.rate)
    found = coherence(record, line, others, tried.fit.noise, periods_in(record, rate))
    if found.share <= PREDICTED_SHARE:
        return replace(tried, why=f"other blocks predict {found.share:.2f} of it")
    excess = level.at(record, rate)
    with_line = gain_over_an_oscillator(
        record, line, others, rate, without, tried.fit, oscillator_gain * excess
    )
    tried = replace(tried, oscillator_gain=with_line / excess)
    if tried.oscillator_gain <= oscillator_gain:
        return replace(tried, why=f"gains {tried.oscillator_gain:.1f} over an oscillator")
    return tried


def _pair(
    record: Record,
    incoherent: Sequence[_Tried],
    rates: Sequence[float],
    without: KernelFit,
    level: Level,
    oscillator_gain: float,
) -> list[_Tried]:
    """Return two lines next to each other, of which one alone is not the same in all blocks; empty
    if there are none."""
    for item in () if record.whole_orders_only else incoherent:
        found = pair_of(
            record,
            item.rate,
            rates,
            without,
            needed=oscillator_gain * level.at(record, item.rate),
            predicted=PREDICTED_SHARE,
            scan=scan,
            moved=_moved,
        )
        lines = [] if found is None else _of_pair(record, found, level)
        if lines and all(line.gain > _needed(record, line.rate, line.gain) for line in lines):
            return lines
    return []


def _of_pair(record: Record, found: Pair, level: Level) -> list[_Tried]:
    """Return the lines of a pair, each with its gain in the terms of :func:`_tried`."""
    lines = []
    for rate, gain, over in zip(found.rates, found.gains, found.oscillator_gains, strict=True):
        excess = level.at(record, rate)
        share = float(own_shares(record, record.line_columns(rate))[0])
        own = record.of_few_rows(gain) * share / excess
        lines.append(_Tried(rate, own, over / excess, found.fit, None))
    return lines


def _ordered(
    record: Record,
    rates: Sequence[float],
    tried: Sequence[_Tried],
    fit: KernelFit,
    rejected: Sequence[Rejected],
) -> LineSearch:
    """Return the lines, ordered by the error that they remove; the figures of each line are
    computed with all other lines in the model."""
    columns = record.columns(np.array(rates))
    rows = record.rows(columns)
    whitened = rows.factor(fit.noise).whiten(rows.values)
    found = np.linalg.lstsq(whitened[:, 1:], whitened[:, 0], rcond=1e-10)[0]
    lines = []
    multiples = _multiples_of(record, rates, fit.noise)
    for at, rate in enumerate(rates):
        others = record.columns(np.array([other for other in rates if other != rate]))
        line = record.line_columns(rate)
        periods = periods_in(record, rate)
        own = found[record.base.shape[1] + 2 * at :][:2]
        cosine, sine = own
        of_all = float(np.sqrt(np.mean((line @ own) ** 2)))
        seen = Coherence(1.0, of_all)
        if not record.whole_orders_only:
            # A line removes at most itself. In noise that is far slower than the line, the columns
            # contain, after the projection, a constant that is larger than the line.
            seen = coherence(record, line, others, fit.noise, periods)
            seen = replace(seen, taken_arcsec=min(seen.taken_arcsec, of_all))
        lines.append(
            Line(
                rate=rate,
                amplitude_arcsec=float(np.hypot(cosine, sine)),
                phase_rad=float(np.arctan2(-sine, cosine)),
                taken_arcsec=seen.taken_arcsec,
                share=seen.share,
                gain=tried[at].gain,
                oscillator_gain=tried[at].oscillator_gain,
                periods=periods,
                independent=record.independent,
                multiple=multiples[at],
            )
        )
    lines.sort(key=lambda line: -line.taken_arcsec)
    return LineSearch(
        record,
        tuple(lines),
        fit,
        whiteness_of(rows, fit.noise),
        rejected=tuple(rejected),
    )
