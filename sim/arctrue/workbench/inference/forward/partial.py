"""Finds a line that exists only in a part of a record.

Over the whole record such a line looks like an oscillation that noise drives: blocks without the
line do not predict the blocks with it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.record import Record, orthonormal
from arctrue.workbench.inference.forward.search import OSCILLATOR_GAIN, search_lines
from arctrue.workbench.noise.kernel import KernelNoise
from arctrue.workbench.noise.kernel_fit import KernelFit, Rows, best_fit, usual_starts
from arctrue.workbench.observations.one_speed import SAME_PHASE_TURNS

Float = NDArray[np.float64]

EDGES = 32
"""Number of equal intervals into which the record is divided in the search for the part. A line
that begins in the middle of an interval loses at most 1/64 of the record."""
AWAY, OVERSAMPLED = 8.0, 4.0
"""Largest distance of the line's rate from the rate of the oscillation, in units of 1/span, and
number of rates per 1/span. A part of an eighth of the record has a peak of this half width."""
WHOLE = 0.9
"""Largest share of the record that counts as a part."""
ABSENT = 0.25
"""The line counts as absent in the other rows if its amplitude there, plus two standard
uncertainties, is at most this share of its amplitude in the part."""
COVERAGE = 2.0
"""Factor of the standard uncertainty, for a coverage of 95 %."""
STEPS = 16
"""Number of places on each side of an edge among which the edge is refined, within one interval."""


@dataclass(frozen=True)
class PartLine:
    """A line that passes the tests of a line in a part of the record and is absent in the other
    rows."""

    hz: float
    sigma_hz: float
    amplitude_arcsec: float
    rms_arcsec: float
    """RMS over all rows of the record."""
    start_s: float
    end_s: float
    score: float
    """Log likelihood score of the record with this line in the model."""


def part_line(record: Record, lines: Float, best: KernelFit, hz: float) -> PartLine | None:
    """Return the line near the frequency ``hz`` that exists only in a part of the record.

    ``lines``: columns of the lines of the whole record; ``best``: its noise with an oscillator. The
    part of the record is chosen among about EDGES²/2 parts. The search for lines must then find the
    line in this part alone, and the line must explain the whole record better than the oscillator.
    Both gains must exceed OSCILLATOR_GAIN by the logarithm of the number of parts.
    """
    around = _rate_of(record, hz)
    if around is None:
        return None
    rows = record.rows(lines)
    needed = OSCILLATOR_GAIN + float(np.log(EDGES**2 / 2.0))
    start, end = _window(record, rows.left(), around)
    if end - start > WHOLE * record.clock.size:
        return None
    found = search_lines(_cut(record, lines, start, end), oscillator_gain=needed)
    near = [one for one in found.lines if abs(one.rate - around) * record.span <= AWAY]
    if not near:
        return None
    rate = max(near, key=lambda one: one.gain).rate
    start, end = _refined(record, rows, rate, start, end, found.noise.noise)
    wave = record.line_columns(rate)
    inside = np.zeros((record.clock.size, 1))
    inside[start:end] = 1.0
    with_line = replace(rows, values=np.hstack([rows.values, wave * inside]))
    grown = best_fit(with_line, [found.noise.noise, *usual_starts(with_line)])
    if grown.score - best.score <= needed:
        return None
    both = replace(rows, values=np.hstack([with_line.values, wave * (1.0 - inside)]))
    fitted, sigma = _fitted(both, grown.noise)
    here, there = float(np.hypot(*fitted[-4:-2])), float(np.hypot(*fitted[-2:]))
    if there + COVERAGE * float(np.max(sigma[-2:])) > ABSENT * here:
        return None
    length = float(record.measured[end - 1] - record.measured[start])
    phase = float(np.max(sigma[-4:-2])) / here
    return PartLine(
        rate if record.in_time else record.on_the_clock(rate),
        # The frequency of a line of the length T with the phase's standard uncertainty u: √12·u/2πT
        float(np.sqrt(12.0) * phase / (2.0 * np.pi * length)),
        here,
        float(here * np.sqrt(0.5 * (end - start) / record.clock.size)),
        float(record.measured[start]),
        float(record.measured[end - 1]),
        grown.score,
    )


def _rate_of(record: Record, hz: float) -> float | None:
    """Return the rate of a frequency in a record; None for a record over the angle at more than one
    speed, because a frequency then has no single rate."""
    if record.in_time:
        return hz
    turns_s = record.turns_on_the_clock
    rate = hz / turns_s
    sense = float(np.sign(record.place[-1] - record.place[0]))
    away = record.place - sense * turns_s * record.measured
    return rate if float(np.ptp(away)) * rate <= SAME_PHASE_TURNS else None


def _window(record: Record, left: Float, rate: float) -> tuple[int, int]:
    """Return the first row and the row after the last of the part that a line near ``rate``
    explains best in white noise."""
    rates = rate + np.arange(-AWAY * OVERSAMPLED, AWAY * OVERSAMPLED + 1.0) / (
        OVERSAMPLED * record.span
    )
    columns = record.columns(rates[rates > 0.0])
    edges = np.linspace(0, left.size, EDGES + 1).astype(np.int64)
    sums = np.vstack(
        [np.zeros(columns.shape[1]), np.cumsum(columns * left[:, np.newaxis], axis=0)]
    )[edges]
    best, found = -1.0, (0, left.size)
    for first in range(EDGES):
        own = sums[first + 1 :] - sums[first]
        # In a part of whole periods, cosine and sine are orthogonal, each of the square rows/2.
        square = own[:, 0::2] ** 2 + own[:, 1::2] ** 2
        gains = np.max(square, axis=1) / (edges[first + 1 :] - edges[first])
        last = int(np.argmax(gains))
        if gains[last] > best:
            best, found = float(gains[last]), (int(edges[first]), int(edges[first + 1 + last]))
    return found


def _cut(record: Record, lines: Float, start: int, end: int) -> Record:
    """Return a part of the record, with the lines of the whole record in its base."""
    kept = slice(start, end)
    place, clock = record.place[kept], record.clock[kept]
    number = np.unique(record.stretch[kept], return_inverse=True)[1]
    return replace(
        record,
        clock=clock,
        measured=record.measured[kept],
        place=place,
        width=record.width[kept],
        readings=record.readings[kept],
        residual_arcsec=record.residual_arcsec[kept],
        base=orthonormal([record.base[kept], lines[kept]]),
        stretch=number,
        clock_span=max(float(np.ptp(clock[number == item])) for item in np.unique(number)),
        span=float(np.ptp(place)),
        longest=max(float(np.ptp(place[number == item])) for item in np.unique(number)),
    )


def _refined(
    record: Record, rows: Rows, rate: float, start: int, end: int, noise: KernelNoise
) -> tuple[int, int]:
    """Return the edges of the part at their most likely rows, with the noise unchanged."""
    factor = rows.factor(noise)
    known = np.linalg.qr(factor.whiten(rows.values[:, 1:]))[0]
    own = factor.whiten(rows.values[:, :1])[:, 0]
    own -= known @ (known.T @ own)
    wave = record.line_columns(rate)

    def gain(first: int, last: int) -> float:
        columns = np.zeros_like(wave)
        columns[first:last] = wave[first:last]
        columns = factor.whiten(columns)
        columns -= known @ (known.T @ columns)
        basis = np.linalg.qr(columns)[0]
        return float(np.sum((basis.T @ own) ** 2))

    size = record.clock.size
    shifts = np.linspace(-size / EDGES, size / EDGES, 2 * STEPS + 1).astype(np.int64)
    middle = (start + end) // 2
    starts = np.unique(np.clip(start + shifts, 0, middle - 1))
    start = int(max(starts, key=lambda first: gain(int(first), end)))
    ends = np.unique(np.clip(end + shifts, middle + 1, size))
    return start, int(max(ends, key=lambda last: gain(start, int(last))))


def _fitted(rows: Rows, noise: KernelNoise) -> tuple[Float, Float]:
    """Return the coefficients of the rows' columns, and their standard uncertainties."""
    whitened = rows.factor(noise).whiten(rows.values)
    columns = whitened[:, 1:]
    fitted = np.linalg.lstsq(columns, whitened[:, 0], rcond=1e-10)[0]
    variance = np.diag(np.linalg.pinv(columns.T @ columns))
    return np.asarray(fitted), np.asarray(np.sqrt(variance))
