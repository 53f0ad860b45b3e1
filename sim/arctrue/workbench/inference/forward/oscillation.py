"""Finds a damped oscillation, driven by noise, as a part of the noise of a record.

Such an oscillation keeps its phase for a few periods only and is therefore not a line. No regular
effect explains the oscillation, but an effect that fits a part of it may look like its cause.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from arctrue.workbench.inference.forward.noise_of_record import whitened_left
from arctrue.workbench.inference.forward.of_solution import has_records, longest_stretch
from arctrue.workbench.inference.forward.own_phases import line_of_runs
from arctrue.workbench.inference.forward.partial import part_line
from arctrue.workbench.inference.forward.prominence import is_prominent
from arctrue.workbench.inference.forward.record import MOST_ROWS, ROWS_A_PERIOD, Record, record_of
from arctrue.workbench.inference.forward.search import LineSearch, search_lines
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.noise.kernel import KernelNoise, Part, log_likelihood
from arctrue.workbench.noise.kernel_fit import KernelFit, Rows, best_fit, fit_from, usual_starts
from arctrue.workbench.observations import CaptureRows
from arctrue.workbench.observations.one_speed import order_at_one_speed

Float = NDArray[np.float64]

LEAST_QUALITY = 2.0
"""Smallest quality of a damped oscillation. At this quality the covariance falls to e^(−π/2) = 0.2
within a period; an oscillation of lower quality counts as slow noise."""
LEAST_GAIN_LOGS = 2.5
"""Smallest gain in log likelihood of an oscillation, in units of log(rows): ½ for each of variance,
decay and frequency, and 1 for the search over about rows/2 frequencies."""
LEAST_SHARE = 0.1
"""Smallest share of the residuals' mean square that an oscillation must have, unless it is
prominent (:func:`is_prominent`). A smaller oscillation may only represent a shape of the spectrum
that no kernel has. This share reaches 0.05 for a moving mean, whose spectral density has zeros (4
logs of each of 16 kinds of noise, ``sim/tests/workbench/noisy_logs.py``)."""
SHARPENED = 3
"""Largest number of rounds; each fits the frequency, then the other parameters. A round without a
gain in likelihood is the last."""
WIDTHS = 1.5
"""Largest change of the frequency in a round, in widths of the resonance between its half
powers."""
OF_A_WIDTH = 0.005
"""Accuracy of the frequency, as a share of the width of the resonance."""
BENT_WIDTHS = 0.25
"""Step for the curvature of the log likelihood, as a share of the width of the resonance."""
PEAK_ORDINATES = (3, 9, 27)
"""Widths of a peak of the spectrum, in ordinates 1/length. With 3 ordinates the coherence time is a
tenth of the record; the search for lines finds peaks wider than 27 ordinates itself."""
WIDER = 4
"""Factor between the lengths of successive records. A record of averaged rows shows resonances up
to 1/4 of its sampling rate, which is 1/16 of the sampling rate of the record before."""
LEAST_ROWS = 400
"""Smallest number of rows of a capture or of a run over stations: the test of Ljung and Box over 20
lags, and a quality of 2, need some tens of periods. It is a quarter of MOST_ROWS."""


@dataclass(frozen=True)
class Oscillation:
    """A resonance in the noise."""

    hz: float
    sigma_hz: float
    """Standard uncertainty of the frequency, with the other parts of the noise unchanged."""
    rms_arcsec: float
    quality: float
    channel: str
    gain: float
    """Gain in log likelihood over the best noise without the oscillation."""
    present_s: tuple[float, float] | None = None
    """Times between which a line that keeps its phase is present; None for a resonance."""
    amplitude_arcsec: float | None = None
    """Amplitude of that line while it is present."""
    in_each_run: str | None = None
    """Amplitude, in words, of a line that keeps its phase only within each run; None for a
    resonance, and for a line in a part of the record."""
    order: float | None = None
    """Order of the angle to which the frequency of a line with a phase for each run corresponds, if
    all runs have one speed."""

    def is_same(self, other: Oscillation) -> bool:
        """Tell whether the other oscillation is this one, from other rows of the channel: the
        frequencies differ by less than the width of the resonance."""
        return self.channel == other.channel and abs(self.hz - other.hz) < self.hz / self.quality

    def data(self) -> dict[str, float | str | list[float] | None]:
        """Return the oscillation as JSON."""
        return {
            "frequency_hz": self.hz,
            "frequency_sigma_hz": self.sigma_hz,
            "rms_arcsec": self.rms_arcsec,
            "quality": self.quality,
            "channel": self.channel,
            "present_s": None if self.present_s is None else list(self.present_s),
            "own_phase_in_each_run": self.in_each_run is not None,
        }

    def words(self) -> str:
        """Describe the oscillation in words: it loses its phase after a number of periods, or it is
        a line in a part of the record or in each run."""
        if self.in_each_run is not None:
            order = "" if self.order is None else f", order {self.order:.5g} at this speed"
            return (
                f"a line of {1.0 / self.hz:.4g} s ({self.hz:.4g} Hz{order}), {self.in_each_run} in "
                f"the {self.channel}, with a phase of its own in each run"
            )
        if self.present_s is not None:
            start_s, end_s = self.present_s
            return (
                f"a line of {1.0 / self.hz:.4g} s, {self.amplitude_arcsec:.3g}″ in the "
                f"{self.channel}, which is present only from {start_s:.4g} s to {end_s:.4g} s and "
                "keeps its phase there"
            )
        return (
            f"a damped oscillation near {self.hz:.3g} Hz (noise-driven), {self.rms_arcsec:.2g}″ "
            f"RMS in the {self.channel}, which keeps its phase for about "
            f"{max(self.quality / np.pi, 1.0):.2g} periods"
        )

    @property
    def is_line(self) -> bool:
        """True for a line that keeps its phase in a part of the rows."""
        return self.present_s is not None or self.in_each_run is not None


def oscillation_of(found: LineSearch, channel: str) -> Oscillation | None:
    """Return the resonance in the noise of a record over time, with the lines of the search in the
    model; None if no resonance is significant.

    The search for lines adds an oscillator only where the spectrum is high over many frequencies.
    Here the noise is fitted again with one oscillator at each of its narrower peaks too.
    """
    record = found.record
    lines = record.columns(np.array([line.rate for line in found.lines]))
    rows = record.rows(lines)
    plain = best_fit(rows, [found.noise.noise.without_oscillators(), *usual_starts(rows)])
    fits = [found.noise, *(fit_from(rows, noise) for noise in _with_a_peak(rows, plain.noise))]
    there = [fit for fit in fits if _is_shown(_largest(fit), record)]
    best = max(there, key=lambda fit: fit.score, default=None)
    part = None if best is None else _largest(best)
    if best is None or part is None:
        return None
    best, part, sigma_hz = _sharpened(rows, best, part)
    if not _is_shown(part, record):
        return None
    gain = best.score - plain.score
    if _quality(part) < LEAST_QUALITY or gain <= LEAST_GAIN_LOGS * float(np.log(rows.clock.size)):
        return None
    small = part.variance < LEAST_SHARE * float(np.mean(rows.left() ** 2))
    reading_step = record.step / float(np.median(record.readings))
    if small and not is_prominent(best.noise, part, reading_step):
        return None
    line = part_line(record, lines, best, part.frequency)
    if line is not None:
        return Oscillation(
            line.hz,
            line.sigma_hz,
            line.rms_arcsec,
            _quality(part),
            channel,
            line.score - plain.score,
            (line.start_s, line.end_s),
            line.amplitude_arcsec,
        )
    rms = float(np.sqrt(part.variance))
    return Oscillation(part.frequency, sigma_hz, rms, _quality(part), channel, gain)


def _with_a_peak(rows: Rows, noise: KernelNoise) -> Iterator[KernelNoise]:
    """Yield the noise with one more oscillator at the highest peak of the whitened residuals'
    spectrum, for each width of the peak."""
    power = np.abs(np.fft.rfft(whitened_left(rows, noise)))[1:] ** 2
    length = rows.step * rows.clock.size
    variance = float(np.mean(rows.left() ** 2)) / 10.0
    for wide in PEAK_ORDINATES:
        if wide < power.size:
            peak = int(np.argmax(np.convolve(power, np.ones(wide) / wide, mode="same")))
            decay = length / (np.pi * wide)
            part = Part("oscillator", variance, decay, (peak + 1) / length)
            yield replace(noise, parts=(*noise.parts, part))


def _is_shown(part: Part | None, record: Record) -> bool:
    """Return whether the record shows the frequency of an oscillation.

    Single rows show at most half their sampling rate. A mean of several readings may show the alias
    of a faster oscillation above the highest rate that is searched.
    """
    if part is None:
        return False
    least = ROWS_A_PERIOD if np.any(record.readings > 1.0) else 2.0
    return part.frequency * record.step <= 1.0 / least


def _largest(fit: KernelFit) -> Part | None:
    parts = [part for part in fit.noise.parts if part.kind == "oscillator"]
    return max(parts, key=lambda item: item.variance, default=None)


def _quality(part: Part) -> float:
    return float(np.pi * part.frequency * part.decay)


def _width_hz(part: Part) -> float:
    """Return the width of the resonance between its half powers."""
    return float(1.0 / (np.pi * part.decay))


def _sharpened(rows: Rows, fit: KernelFit, part: Part) -> tuple[KernelFit, Part, float]:
    """Return the noise with the oscillator at its most likely frequency, that oscillator, and the
    frequency's standard uncertainty.

    The search takes the frequency from a smoothed spectrum. Here the frequency and the other
    parameters are fitted in turn; the uncertainty follows from the curvature of the log likelihood.
    """
    for _ in range(SHARPENED):
        wide = min(WIDTHS * _width_hz(part), 0.9 * part.frequency)
        place = minimize_scalar(
            partial(_cost, rows, fit.noise, part),
            bounds=(part.frequency - wide, part.frequency + wide),
            method="bounded",
            options={"xatol": OF_A_WIDTH * _width_hz(part)},
        )
        there = fit_from(rows, _with_frequency(fit.noise, part, float(place.x)))
        if there.log_likelihood <= fit.log_likelihood:
            break
        fit, part = there, _largest(there) or part
    step = BENT_WIDTHS * _width_hz(part)
    low, here, high = (
        _cost(rows, fit.noise, part, part.frequency + move) for move in (-step, 0.0, step)
    )
    bend = low + high - 2.0 * here
    return fit, part, float(step / np.sqrt(bend)) if bend > 0.0 else _width_hz(part)


def _cost(rows: Rows, noise: KernelNoise, part: Part, hz: float) -> float:
    moved = _with_frequency(noise, part, hz)
    return -log_likelihood(rows.clock, rows.readings, rows.values, moved)


def _with_frequency(noise: KernelNoise, part: Part, hz: float) -> KernelNoise:
    parts = tuple(replace(one, frequency=hz) if one is part else one for one in noise.parts)
    return replace(noise, parts=parts)


def oscillation_in_capture(solution: Solution) -> Oscillation | None:
    """Return the resonance in the run with the most rows, with the model's coefficients unchanged;
    None if there is none.

    With more than two heads each channel is searched. The channel with the largest gain gives the
    size; the gain is the sum over the channels with the same resonance.
    """
    rows, left = solution.observations.capture, solution.capture_residual_arcsec()
    if rows is None or left is None or "capture" in solution.unknown_noise:
        return None
    every = (_in_channel(rows, left, channel) for channel in range(rows.channels))
    found = [item for item in every if item is not None]
    first = max(found, key=lambda item: item.gain, default=None)
    if first is None:
        return None
    return replace(first, gain=sum(item.gain for item in found if first.is_same(item)))


def _in_channel(rows: CaptureRows, left: Float, channel: int) -> Oscillation | None:
    """Return the resonance in the longest run of a channel; its gain is scaled to all runs."""
    count = np.bincount(rows.run)[channel :: rows.channels]
    longest = rows.channels * int(np.argmax(count)) + channel
    kept = np.flatnonzero(rows.run == longest)
    time_s = rows.time_s[kept]
    if kept.size < LEAST_ROWS or not np.all(np.diff(time_s) > 0.0):
        return None
    records = [*_first_rows(time_s, left[kept]), _record(time_s, left[kept])]
    return _in_records(records, "capture", int(count.sum()))


def oscillation_in_reference(solution: Solution) -> Oscillation | None:
    """Return the resonance in the longest stretch of the reference; None if there is none. The
    averaged rows of :func:`records_of` do not show this resonance, because it is too fast or the
    rows are stations."""
    found = longest_stretch(solution)
    if found is None:
        return None
    time_s, left, rows = found
    records = [*_first_rows(time_s, left)]
    if LEAST_ROWS <= time_s.size <= MOST_ROWS and (rows > MOST_ROWS or not has_records(solution)):
        # records_of averages the rows if all stretches together have too many, and makes no record
        # of stations.
        records.append(_record(time_s, left))
    return in_each_run(solution, _in_records(records, "reference", rows))


def in_each_run(solution: Solution, found: Oscillation | None) -> Oscillation | None:
    """Return an oscillation of the reference as a line, if each run keeps the line's phase."""
    if found is None or found.is_line:
        return found
    line = _of_runs(solution, found.hz, found.hz / found.quality)
    return found if line is None else replace(line, gain=max(line.gain, found.gain))


def line_in_each_run(solution: Solution, hz: float) -> Oscillation | None:
    """Return a line of the reference near a frequency if it keeps its phase only within each run;
    None otherwise.

    A fit with one phase for all runs describes such a line as two lines at other frequencies.
    """
    longest = longest_stretch(solution)
    if longest is None:
        return None
    return _of_runs(solution, hz, 1.0 / float(np.ptp(longest[0])))


def _of_runs(solution: Solution, hz: float, width_hz: float) -> Oscillation | None:
    line = line_of_runs(solution, hz, width_hz)
    if line is None:
        return None
    rows = solution.observations.every_reference_row
    return Oscillation(
        line.hz,
        line.sigma_hz,
        line.rms_arcsec,
        hz / width_hz,
        "reference",
        line.gain,
        in_each_run=line.size_words(),
        order=None if rows is None else order_at_one_speed(rows, line.hz),
    )


def _in_records(records: Iterable[Record], channel: str, rows: int) -> Oscillation | None:
    """Return the resonance with the largest gain, from the record that determines it best.

    The gain of each record is scaled to ``rows`` readings, because the gain of all readings would
    be larger in proportion to their number. An alias of a faster resonance, which the averaging of
    rows reduces, has a smaller scaled gain than the resonance in single rows.
    """
    found = []
    for record in records:
        item = oscillation_of(search_lines(record), channel)
        if item is not None:
            found.append((item, item.gain * rows / float(np.sum(record.readings))))
    if not found:
        return None
    first, gain = max(found, key=lambda pair: pair[1])
    same = [item for item, _ in found if first.is_same(item)]
    return replace(max(same, key=lambda item: item.gain), gain=gain)


def _first_rows(time_s: Float, left_arcsec: Float) -> Iterator[Record]:
    """Yield the first MOST_ROWS rows. Each further record contains WIDER times as many rows,
    averaged to as many rows as before; no record contains all rows."""
    block = 1
    while block * MOST_ROWS < time_s.size:
        part = slice(block * MOST_ROWS)
        yield _record(time_s[part], left_arcsec[part])
        block *= WIDER


def _record(time_s: Float, left_arcsec: Float) -> Record:
    none = np.zeros((time_s.size, 0))
    one_stretch = np.zeros(time_s.size, dtype=np.int64)
    return record_of(time_s, time_s, one_stretch, left_arcsec, none, in_time=True)
