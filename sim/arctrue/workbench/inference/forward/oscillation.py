"""A damped oscillation that noise drives, as a part of the noise of a record.

It keeps its phase for some of its periods only, so that it is no line: no effect that is regular
explains it, and whatever follows it for a while is taken for one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.record import Record, record_of
from arctrue.workbench.inference.forward.search import LineSearch, search_lines
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.noise.kernel_fit import best_fit, usual_starts

Float = NDArray[np.float64]

LEAST_QUALITY = 2.0
"""Of a damped oscillation: with less its covariance has fallen to e^(−π/2) = 0.2 within a period,
and it is slow noise."""
LEAST_GAIN_LOGS = 2.0
"""Logarithms of the rows that it must gain: ½ for each of variance, decay and frequency, and ½ for
the frequencies that were tried."""
LEAST_SHARE = 0.1
"""Of the mean square that is left: with less it may stand for a shape of the noise that no kernel
has (of a moving mean, whose density has zeros, 0.05; 4 logs of each of 16 kinds of noise,
``sim/tests/workbench/noisy_logs.py``)."""
MOST_CAPTURE_ROWS = 1600
"""Rows of a capture, one after the other and none averaged: its oscillations are fast."""
LEAST_CAPTURE_ROWS = 400
"""A quarter of the rows that are used of a long run: Ljung and Box over 20 lags and a
quality of 2 need some tens of periods."""


@dataclass(frozen=True)
class Oscillation:
    """A resonance in the noise."""

    hz: float
    rms_arcsec: float
    quality: float
    channel: str
    gain: float
    """Log likelihood over the best noise without it."""

    def data(self) -> dict[str, float | str]:
        """As JSON."""
        return {
            "frequency_hz": self.hz,
            "rms_arcsec": self.rms_arcsec,
            "quality": self.quality,
            "channel": self.channel,
        }

    def words(self) -> str:
        """In words; of one whose frequency wanders the phase is lost as well."""
        return (
            f"a damped oscillation near {self.hz:.3g} Hz (noise-driven), {self.rms_arcsec:.2g}″ "
            f"RMS in the {self.channel}, which keeps its phase for about "
            f"{max(self.quality / np.pi, 1.0):.2g} periods"
        )


def oscillation_of(found: LineSearch, channel: str) -> Oscillation | None:
    """The resonance in the noise of a record over time, its lines in the model."""
    parts = [part for part in found.noise.noise.parts if part.kind == "oscillator"]
    if not parts:
        return None
    part = max(parts, key=lambda item: item.variance)
    quality = np.pi * part.frequency * part.decay
    if quality < LEAST_QUALITY:
        return None
    lines = found.record.columns(np.array([line.rate for line in found.lines]))
    rows = found.record.rows(lines)
    if part.variance < LEAST_SHARE * float(np.mean(rows.left() ** 2)):
        return None
    plain = best_fit(rows, [found.noise.noise.without_oscillators(), *usual_starts(rows)])
    gain = found.noise.score - plain.score
    if gain <= LEAST_GAIN_LOGS * float(np.log(rows.clock.size)):
        return None
    rms = float(np.sqrt(part.variance))
    return Oscillation(part.frequency, rms, float(quality), channel, gain)


def oscillation_in_capture(solution: Solution) -> Oscillation | None:
    """The same of the longest run of a capture, its first rows, the model's coefficients held.

    The gain is that of all rows.
    """
    record, rows = _record_of_capture(solution), solution.observations.capture
    if record is None or rows is None:
        return None
    found = oscillation_of(search_lines(record), "capture")
    if found is None:
        return None
    # All rows together would tell so much more of it.
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
