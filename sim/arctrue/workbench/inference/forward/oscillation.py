"""Finds a damped oscillation, driven by noise, as a part of the noise of a record.

Such an oscillation keeps its phase for a few periods only and is therefore not a line. No regular
effect explains the oscillation, but an effect that fits a part of it may look like its cause.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from arctrue.workbench.inference.forward.record import Record, record_of
from arctrue.workbench.inference.forward.search import LineSearch, search_lines
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.noise.kernel import KernelNoise, Part, log_likelihood
from arctrue.workbench.noise.kernel_fit import KernelFit, Rows, best_fit, fit_from, usual_starts

Float = NDArray[np.float64]

LEAST_QUALITY = 2.0
"""Smallest quality of a damped oscillation. At this quality the covariance falls to e^(−π/2) = 0.2
within a period; an oscillation of lower quality counts as slow noise."""
LEAST_GAIN_LOGS = 2.0
"""Smallest gain in log likelihood of an oscillation, in units of log(rows): ½ for each of variance,
decay and frequency, and ½ for the search over frequencies."""
LEAST_SHARE = 0.1
"""Smallest share of the residuals' mean square that an oscillation must have. A smaller oscillation
may only represent a shape of the spectrum that no kernel has: this share reaches 0.05 for a moving
mean, whose spectral density has zeros (4 logs of each of 16 kinds of noise,
``sim/tests/workbench/noisy_logs.py``)."""
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
MOST_CAPTURE_ROWS = 1600
"""Largest number of consecutive rows of a capture. These rows are not averaged, since the
oscillations in a capture are fast."""
LEAST_CAPTURE_ROWS = 400
"""Smallest number of rows of a capture: the test of Ljung and Box over 20 lags, and a quality of 2,
need some tens of periods. It is a quarter of MOST_CAPTURE_ROWS."""


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

    def data(self) -> dict[str, float | str]:
        """Return the oscillation as JSON."""
        return {
            "frequency_hz": self.hz,
            "frequency_sigma_hz": self.sigma_hz,
            "rms_arcsec": self.rms_arcsec,
            "quality": self.quality,
            "channel": self.channel,
        }

    def words(self) -> str:
        """Describe the oscillation in words: it loses its phase after a number of periods."""
        return (
            f"a damped oscillation near {self.hz:.3g} Hz (noise-driven), {self.rms_arcsec:.2g}″ "
            f"RMS in the {self.channel}, which keeps its phase for about "
            f"{max(self.quality / np.pi, 1.0):.2g} periods"
        )


def oscillation_of(found: LineSearch, channel: str) -> Oscillation | None:
    """Return the resonance in the noise of a record over time, with the lines of the search in the
    model; None if no resonance is significant."""
    part = _largest(found.noise)
    if part is None or _quality(part) < LEAST_QUALITY:
        return None
    lines = found.record.columns(np.array([line.rate for line in found.lines]))
    rows = found.record.rows(lines)
    if part.variance < LEAST_SHARE * float(np.mean(rows.left() ** 2)):
        return None
    plain = best_fit(rows, [found.noise.noise.without_oscillators(), *usual_starts(rows)])
    gain = found.noise.score - plain.score
    if gain <= LEAST_GAIN_LOGS * float(np.log(rows.clock.size)):
        return None
    part, sigma_hz = _sharpened(rows, found.noise, part)
    rms = float(np.sqrt(part.variance))
    return Oscillation(part.frequency, sigma_hz, rms, _quality(part), channel, gain)


def _largest(fit: KernelFit) -> Part | None:
    parts = [part for part in fit.noise.parts if part.kind == "oscillator"]
    return max(parts, key=lambda item: item.variance, default=None)


def _quality(part: Part) -> float:
    return float(np.pi * part.frequency * part.decay)


def _width_hz(part: Part) -> float:
    """Return the width of the resonance between its half powers."""
    return float(1.0 / (np.pi * part.decay))


def _sharpened(rows: Rows, fit: KernelFit, part: Part) -> tuple[Part, float]:
    """Return the oscillator at its most likely frequency, and the frequency's standard uncertainty.

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
    return part, float(step / np.sqrt(bend)) if bend > 0.0 else _width_hz(part)


def _cost(rows: Rows, noise: KernelNoise, part: Part, hz: float) -> float:
    moved = _with_frequency(noise, part, hz)
    return -log_likelihood(rows.clock, rows.readings, rows.values, moved)


def _with_frequency(noise: KernelNoise, part: Part, hz: float) -> KernelNoise:
    parts = tuple(replace(one, frequency=hz) if one is part else one for one in noise.parts)
    return replace(noise, parts=parts)


def oscillation_in_capture(solution: Solution) -> Oscillation | None:
    """Return the resonance in the first rows of the run with the most rows, with the model's
    coefficients unchanged; None if there is none.

    The gain is scaled to all rows of the capture.
    """
    record, rows = _record_of_capture(solution), solution.observations.capture
    if record is None or rows is None:
        return None
    found = oscillation_of(search_lines(record), "capture")
    if found is None:
        return None
    # The gain of all rows would be larger, in proportion to their number.
    return replace(found, gain=found.gain * rows.run.size / record.clock.size)


def _record_of_capture(solution: Solution) -> Record | None:
    rows, left = solution.observations.capture, solution.capture_residual_arcsec()
    if rows is None or left is None or "capture" in solution.unknown_noise:
        return None
    longest = int(np.argmax(np.bincount(rows.run)))
    kept = np.flatnonzero(rows.run == longest)[:MOST_CAPTURE_ROWS]
    time_s = rows.time_s[kept]
    if kept.size < LEAST_CAPTURE_ROWS or not np.all(np.diff(time_s) > 0.0):
        return None
    none = np.zeros((kept.size, 0))
    one_stretch = np.zeros(kept.size, dtype=np.int64)
    return record_of(time_s, time_s, one_stretch, left[kept], none, in_time=True)
