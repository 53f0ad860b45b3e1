"""Tests whether the residuals change in the same way forward and backward in time.

Normal noise of any colour does: rises are as steep as falls. A head or a drive that creeps and then
slips back does not. The noise model absorbs such a motion as slow noise, so that the whitened
residuals remain white.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from arctrue.base.runs import run_spans
from arctrue.workbench.inference.forward.of_solution import has_records
from arctrue.workbench.inference.residuals import Residuals

Float = NDArray[np.float64]

LEAST_CHANGES = 50
"""Smallest number of changes without common rows; the mean of 50 independent values has nearly a
normal distribution."""
LARGEST_CHANGE = 4.0
"""Limit of a change, in root mean squares of the changes; larger changes are clipped to this limit,
so that single wrong rows and single jumps count little."""
LENGTHS = 4
"""Number of block lengths over which the correlation of the changes is summed. Changes of white
noise are correlated over two block lengths."""
OF_NORMAL_NOISE = 6.0
"""Mean square of u³ − 3u for normal u of variance 1; the mean product of two such polynomials is
6ρ³."""


@dataclass(frozen=True)
class Asymmetry:
    """Changes of the residuals that are steeper in one direction than in the other."""

    p_value: float
    """Probability that noise shows so large an asymmetry for any block length, channel or sense.
    The tails of the noise are those of the side (rises or falls) with the shorter tail."""
    p_in_tails: float
    """The same probability, if the tails of the noise are those of all changes."""
    rises: bool
    """True if the steep changes are rises, in the positive direction of the table if
    ``by_direction`` is True."""
    by_direction: bool
    """True if the steep changes have opposite signs in the two directions of the table."""
    rms_arcsec: float
    """Root mean square of the changes from block to block, without those of white noise."""
    step_s: float
    """Length of the block at which the asymmetry is largest."""
    of_reference: bool = False
    """True for a log of the reference, False for R₂ − R₁."""

    def words(self) -> str:
        """Describe the asymmetry in words."""
        rise, fall = ("jumps up", "falls") if self.rises else ("jumps down", "rises")
        where = (
            " in the positive direction (the opposite in the other)" if self.by_direction else ""
        )
        what, like = ("R₂ − R₁", "a bracket")
        if self.of_reference:
            what, like = ("the error of the reference", "a drive, a mount or a cable")
        return (
            f"{what} {rise} again and again{where} and {fall} slowly in between (changes within "
            f"{self.step_s:.2g} s: {self.rms_arcsec:.2g}″ RMS), like {like} that sticks and slips"
        )


@dataclass(frozen=True, eq=False)
class _Values:
    """Residuals of one channel of a capture, or of a log of the reference."""

    values: Float
    spans: Sequence[tuple[int, int]]
    """First row of each run, and the row after its last."""
    ways: Float
    """Direction of each run."""
    step_s: float
    white_arcsec: float
    of_reference: bool


def asymmetry_in_time(residuals: Residuals) -> Asymmetry | None:
    """Return the most significant asymmetry of the residuals of a capture and of a log of the
    reference; None without them, or with too few rows.

    For blocks of 1, 2, 4, … rows, the changes of the mean from each block to the next are divided
    by their root mean square. The mean of the Hermite polynomial u³ − 3u of these changes is 0 for
    noise that is symmetric in time. Its variance is that of normal noise with the measured
    correlation, 6·Σρ³, times the mean square of the polynomial over 6 if the changes have longer
    tails.
    """
    found: list[tuple[float, float, Asymmetry]] = []
    for part in [*_of_capture(residuals), *_of_log(residuals)]:
        size = 1
        while sum(end - start for start, end in part.spans) >= 2 * size * LEAST_CHANGES:
            changes = [_changes(part.values[start:end], size) for start, end in part.spans]
            for by_direction in (False, True)[: 1 + int(np.unique(part.ways).size > 1)]:
                signs = part.ways if by_direction else np.ones(len(part.spans))
                turned = [one * sign for one, sign in zip(changes, signs, strict=True)]
                ratio, in_tails, square = _asymmetry(turned, size)
                rms = np.sqrt(max(square - 2.0 * part.white_arcsec**2 / size, 0.0))
                item = Asymmetry(
                    1.0,
                    1.0,
                    bool(ratio > 0.0),
                    by_direction,
                    float(rms),
                    size * part.step_s,
                    part.of_reference,
                )
                found.append((abs(ratio), abs(in_tails), item))
            size *= 2
    if not found:
        return None
    ratio, in_tails, best = max(found, key=lambda item: item[1])
    p_value, p_in_tails = (
        min(1.0, 2.0 * float(ndtr(-one)) * len(found)) for one in (ratio, in_tails)
    )
    return replace(best, p_value=p_value, p_in_tails=p_in_tails)


def _of_capture(residuals: Residuals) -> Iterator[_Values]:
    """Yield the residuals of each channel of the capture."""
    rows, values, noise = (
        residuals.observations.capture,
        residuals.capture_arcsec,
        residuals.solution.noise.capture,
    )
    if rows is None or values is None or noise is None:
        return
    for channel in range(rows.channels):
        spans = [one for one in run_spans(rows.run) if rows.run[one[0]] % rows.channels == channel]
        ways = np.array([np.sign(rows.direction[start]) for start, _ in spans])
        step_s = _usual_step(rows.time_s, spans)
        yield _Values(values, spans, ways, step_s, noise.white_rms_arcsec, of_reference=False)


def _of_log(residuals: Residuals) -> Iterator[_Values]:
    """Yield the residuals of the reference, if it is a log over time."""
    rows, values, noise = (
        residuals.observations.reference,
        residuals.reference_arcsec,
        residuals.solution.noise.reference,
    )
    if rows is None or values is None or noise is None or rows.time_s is None:
        return
    spans = [(start, end) for start, end in run_spans(rows.run) if end - start > 1]
    if not spans or not has_records(residuals.solution):
        return
    ways = np.ones(len(spans))
    if rows.direction is not None:
        ways = np.array([np.sign(rows.direction[start]) for start, _ in spans])
    step_s = _usual_step(rows.time_s, spans)
    yield _Values(values, spans, ways, step_s, noise.white_rms_arcsec, of_reference=True)


def _usual_step(time_s: Float, spans: Sequence[tuple[int, int]]) -> float:
    return float(np.median([np.median(np.diff(time_s[start:end])) for start, end in spans]))


def _changes(values: Float, size: int) -> Float:
    """Return the change of the mean from each ``size`` rows to the next ``size`` rows."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    if values.size < 2 * size:
        return np.zeros(0)
    return np.asarray((total[2 * size :] - 2.0 * total[size:-size] + total[: -2 * size]) / size)


def _asymmetry(changes: Sequence[Float], size: int) -> tuple[float, float, float]:
    """Return the asymmetry in standard deviations, with the tails of the side with the shorter tail
    and with those of all changes, and the mean square of the changes."""
    square = float(np.mean(np.concatenate(changes) ** 2))
    if square <= 0.0:
        return 0.0, 0.0, 0.0
    units = [one / np.sqrt(square) for one in changes]
    clipped = np.clip(np.concatenate(units), -LARGEST_CHANGE, LARGEST_CHANGE)
    cubes = clipped**3 - 3.0 * clipped
    lags = np.arange(LENGTHS * size)
    normal = 1e-300
    for one in units:
        there = lags[lags < one.size]
        rows = one.size - there
        correlation = _products(one, there) / np.maximum(rows, 1)
        twice = np.where(there > 0, 2.0, 1.0)
        normal += OF_NORMAL_NOISE * float(np.sum(twice * rows * correlation**3))
    total = float(cubes.sum()) / float(np.sqrt(max(normal, 1e-300)))
    sides = [cubes[side] for side in (clipped > 0.0, clipped < 0.0) if side.any()]
    shorter = min(float(np.mean(side**2)) for side in sides) / OF_NORMAL_NOISE
    every = float(np.mean(cubes**2)) / OF_NORMAL_NOISE
    return total / np.sqrt(max(shorter, 1.0)), total / np.sqrt(max(every, 1.0)), square


def _products(values: Float, lags: NDArray[np.int64]) -> Float:
    """Return the sums of products of values ``lags`` rows apart."""
    power = np.abs(np.fft.rfft(values, 2 * values.size)) ** 2
    return np.asarray(np.fft.irfft(power, 2 * values.size)[lags])


__all__ = ["Asymmetry", "asymmetry_in_time"]
