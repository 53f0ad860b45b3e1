"""Finds a line that keeps its phase within each run of a reference, but not from run to run.

The phase is free in each run if the clock of a sensor starts anew, or if the line is the alias of a
faster one and the instants of the rows start anew. With one phase for all runs such a line looks
like an oscillation that noise drives.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincc

from arctrue.workbench.inference.forward.of_solution import stretches_of
from arctrue.workbench.inference.forward.record import MOST_ROWS, ROWS_A_PERIOD, Record, record_of
from arctrue.workbench.inference.forward.scan_of_rates import scan
from arctrue.workbench.inference.forward.search import OSCILLATOR_GAIN, PREDICTED_SHARE
from arctrue.workbench.inference.forward.tests_of_a_line import (
    DECLARED_PERIODS,
    FAMILY_WISE,
    coherence,
)
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.noise.kernel import KernelNoise
from arctrue.workbench.noise.kernel_fit import best_fit, fit_from, usual_starts, with_oscillator

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

MOST_RUNS = 8
"""Largest number of runs that are tested, the longest, to limit cost: each run adds two columns.
It is the number of blocks of the search for lines."""
OVERSAMPLED = 4.0
"""Number of rates per 1/length of the longest run among which the line is searched."""
AWAY = 2.0
"""Largest distance of the line from the oscillation, in units of 1/length of the longest run and in
widths of the resonance, whichever is larger."""
EQUAL_RATIO = 1.5
"""Largest ratio of two amplitudes with which one amplitude is stated for all runs."""

MOST_RATES = 4000
"""Largest number of rates of a line with one phase, to limit cost: pauses of 100 run lengths
between eight runs need as many."""

REFINED, STEP_RATIO = 4, 0.2
"""Number of refinements of the rate, and ratio of their steps, as in the search for lines; the last
step is 1/2,500 of the resolution of the longest run."""

ABSENT = 0.25
"""The line counts as absent in a run if its amplitude there is below this share of its largest
amplitude, as in the search for a line in a part of a record."""


@dataclass(frozen=True)
class LineOfRuns:
    """A line with one frequency, and a phase of its own in each run."""

    hz: float
    sigma_hz: float
    amplitudes_arcsec: tuple[float, ...]
    """Amplitude in each run that was tested."""
    rms_arcsec: float
    gain: float
    """Gain in log likelihood over the best noise without the line and without an oscillation,
    scaled from the rows of the record to every row."""

    def size_words(self) -> str:
        """Return one amplitude for all runs, or the range of the amplitudes."""
        low, high = min(self.amplitudes_arcsec), max(self.amplitudes_arcsec)
        if high > EQUAL_RATIO * low:
            return f"{low:.3g}″ to {high:.3g}″"
        return f"{float(np.sqrt(np.mean(np.square(self.amplitudes_arcsec)))):.3g}″"


def line_of_runs(solution: Solution, hz: float, width_hz: float) -> LineOfRuns | None:
    """Return the line near the oscillation at ``hz`` that each run of the reference has; None if
    there is none.

    The line must be significant among all rates with a free amplitude and phase in each run. Its
    gain over an oscillator at its frequency must reach OSCILLATOR_GAIN for each run, because each
    run is a record of its own. Other blocks of a run must predict more than half of the line in
    this run. A fit with one phase for all runs must have a smaller log likelihood, by more than the
    penalty for the further phases.
    """
    record = _record(solution, hz)
    if record is None:
        return None
    numbers = np.unique(record.stretch)
    rows = record.rows()
    plain = best_fit(rows, usual_starts(rows))
    rates = _rates(record, hz, width_hz)
    white = KernelNoise(max(float(np.mean(rows.left() ** 2 * rows.readings)), 1e-30))
    rate = _best(record, rates, white)
    grown = best_fit(record.rows(_columns(record, rate)), [plain.noise, *usual_starts(rows)])
    for finer in range(REFINED):
        step = 1.0 / (OVERSAMPLED * record.longest) * STEP_RATIO**finer
        rate = _best(record, rate + np.linspace(-step, step, 11), grown.noise)
    columns = _columns(record, rate)
    both = record.rows(columns)
    grown = fit_from(both, grown.noise)
    gain = grown.score - plain.score
    trials = OVERSAMPLED * max(record.highest * record.longest, 1.0)
    if trials * float(gammaincc(numbers.size, max(gain, 0.0))) > FAMILY_WISE:
        return None
    variance = float(np.mean(rows.left() ** 2) - np.mean(both.left() ** 2))
    rivals = [
        fit_from(rows, with_oscillator(noise, rows, rate, max(variance, 1e-30)))
        for noise in (plain.noise, grown.noise)
    ]
    rival = max(fit.log_likelihood for fit in (*rivals, plain))
    if grown.log_likelihood - rival <= OSCILLATOR_GAIN * numbers.size:
        return None
    shortest = min(float(np.ptp(record.place[record.stretch == item])) for item in numbers)
    none = np.zeros((record.clock.size, 0))
    periods = rate * shortest
    if (
        coherence(record, columns, none, grown.noise, periods, along=_along(record)).share
        <= PREDICTED_SHARE
    ):
        return None
    one = _gain_with_one_phase(record, rate, grown.noise)
    each = _gain(record, rate, grown.noise)
    if each - one <= (numbers.size - 1) * float(np.log(record.clock.size)):
        return None
    every = solution.observations.every_reference_row
    share = 1.0 if every is None else float(np.sum(record.readings)) / every.run.size
    return _measured(record, rate, columns, grown.noise, gain / min(share, 1.0))


def _record(solution: Solution, hz: float) -> Record | None:
    """Return the runs with at least three periods, the longest, as a record over time; None with
    fewer than two such runs, or if they have less than half of the rows.

    Averaged rows are used if they have four rows a period, otherwise the first single rows of each
    run.
    """
    found = stretches_of(solution)
    if found is None:
        return None
    time_s, left, columns, stretch = found
    count = np.bincount(stretch)
    lengths = np.array([float(np.ptp(time_s[stretch == item])) for item in range(count.size)])
    usable = np.flatnonzero(lengths * hz >= DECLARED_PERIODS)
    usable = usable[np.argsort(-lengths[usable], kind="stable")][:MOST_RUNS]
    kept = np.isin(stretch, usable)
    if usable.size < 2 or np.count_nonzero(kept) < stretch.size / 2.0:
        return None
    step = float(np.median(np.diff(time_s)[np.diff(stretch) == 0]))
    averaged = -(-np.count_nonzero(kept) // MOST_ROWS)
    if averaged > 1 and hz * step * averaged * ROWS_A_PERIOD > 1.0:
        starts = np.searchsorted(stretch, stretch)
        kept &= np.arange(stretch.size) - starts < MOST_ROWS // usable.size
    number = np.unique(stretch[kept], return_inverse=True)[1]
    time_s, left, columns = time_s[kept], left[kept], columns[kept]
    return record_of(time_s, time_s, number, left, columns, in_time=True)


def _rates(record: Record, hz: float, width_hz: float) -> Float:
    step = 1.0 / (OVERSAMPLED * record.longest)
    reach = AWAY * max(1.0 / record.longest, width_hz)
    rates = hz + np.arange(-np.ceil(reach / step), np.ceil(reach / step) + 1.0) * step
    return np.asarray(rates[rates > 0.0])


def _columns(record: Record, rate: float) -> Float:
    """Return cos and sin of each run, zero in all other runs; shape (rows, 2·runs)."""
    own = record.stretch[:, np.newaxis] == np.unique(record.stretch)
    waves = record.line_columns(rate)
    return np.hstack([own[:, at : at + 1] * waves for at in range(own.shape[1])])


def _along(record: Record) -> Float:
    """Return the place of each row within its run, from 0 to 1."""
    found = np.zeros(record.clock.size)
    for number in np.unique(record.stretch):
        own = np.flatnonzero(record.stretch == number)
        found[own] = np.arange(own.size) / own.size
    return found


def _best(record: Record, rates: Float, noise: KernelNoise) -> float:
    return float(max(rates.tolist(), key=lambda rate: _gain(record, rate, noise)))


def _gain(record: Record, rate: float, noise: KernelNoise) -> float:
    """Return the rise of the log likelihood by a line with a phase for each run, with the noise
    unchanged."""
    return 0.5 * float(np.sum(_projected(record, _columns(record, rate), noise) ** 2))


def _gain_with_one_phase(record: Record, rate: float, noise: KernelNoise) -> float:
    """Return the largest rise of the log likelihood by a line near ``rate`` with one phase."""
    wide = AWAY / record.longest
    count = int(np.clip(2.0 * wide * record.span * OVERSAMPLED, 2, MOST_RATES))
    rates = np.linspace(max(rate - wide, 0.1 * rate), rate + wide, count)
    return float(np.max(scan(record, rates, np.zeros((record.clock.size, 0)), noise)))


def _projected(record: Record, columns: Float, noise: KernelNoise) -> Float:
    rows = record.rows(columns)
    whitened = rows.factor(noise).whiten(rows.values)
    split = rows.values.shape[1] - columns.shape[1]
    known = np.linalg.qr(whitened[:, 1:split])[0]
    both = np.column_stack([whitened[:, :1], whitened[:, split:]])
    both -= known @ (known.T @ both)
    return np.asarray(np.linalg.qr(both[:, 1:])[0].T @ both[:, 0])


def _measured(
    record: Record, rate: float, columns: Float, noise: KernelNoise, gain: float
) -> LineOfRuns | None:
    """Return the line with its sizes; None if it is absent in a run: an order of the angle has
    another frequency in a run of another speed."""
    rows = record.rows(columns)
    whitened = rows.factor(noise).whiten(rows.values)
    fitted = np.linalg.lstsq(whitened[:, 1:], whitened[:, 0], rcond=1e-10)[0]
    inverse = np.linalg.pinv(whitened[:, 1:].T @ whitened[:, 1:])
    width = columns.shape[1]
    sigma = np.sqrt(np.diag(inverse)[-width:]).reshape(-1, 2).max(axis=1)
    sizes = np.hypot(*fitted[-width:].reshape(-1, 2).T)
    lengths = np.array(
        [np.ptp(record.place[record.stretch == item]) for item in np.unique(record.stretch)]
    )
    # The frequency of a line of the length T with the phase's uncertainty u: √12·u/(2πT)
    weights = (2.0 * np.pi * lengths * sizes / sigma) ** 2 / 12.0
    if np.min(sizes) < ABSENT * np.max(sizes) or np.min((sizes / sigma) ** 2) < 2 * OSCILLATOR_GAIN:
        return None
    wave = columns @ fitted[-width:]
    return LineOfRuns(
        rate,
        float(1.0 / np.sqrt(np.sum(weights))),
        tuple(float(size) for size in sizes),
        float(np.sqrt(np.mean(wave**2))),
        gain,
    )
