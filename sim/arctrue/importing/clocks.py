"""Estimates the offset between the clocks of two logs of the same motion, with its uncertainty."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]

LARGEST_GRID = 1 << 20
PARTS = 8
"""Number of parts into which the log is divided; an offset is estimated for each part."""
RIVAL = 0.98
"""Ratio of the second peak of the correlation to the highest, above which the offset is
ambiguous."""
LEAST_MATCH = 0.5
LEAST_VARIATION = 1e-3
"""Relative variation of the speed; if the motion varies less, the clock offset cannot be
determined."""


class UndeterminedOffsetError(ValueError):
    """Is raised when the motion does not determine the clock offset; ``candidates_s`` lists offsets
    that fit equally well."""

    def __init__(self, message: str, candidates_s: tuple[float, ...] = ()) -> None:
        """Store the message and the candidates."""
        super().__init__(message)
        self.candidates_s = candidates_s


@dataclass(frozen=True)
class ClockOffset:
    """Clock offset: the reference's time plus this offset is the encoder's time.

    ``u_s``: standard uncertainty, from the scatter of the offsets of parts of the log.
    ``drift_ppm``, ``u_drift_ppm``: rate of the encoder's clock divided by the rate of the
    reference's clock, minus 1, in 10⁻⁶, and its standard uncertainty. ``left_s``: largest
    difference between ``offset_s`` and the offset of a part of the log. All values except
    ``offset_s`` are NaN if fewer than three parts determine an offset.
    """

    offset_s: float
    u_s: float
    drift_ppm: float
    u_drift_ppm: float
    left_s: float


def clock_offset(
    reference_time_s: Float, reference_turns: Float, time_s: Float, turns: Float
) -> ClockOffset:
    """Estimate the clock offset that aligns two logs of one motion.

    The cross-correlation of the speeds gives the offset to within one sample. Least squares on the
    angles, ``turns(t + τ) = ±reference(t) + c``, refines it.

    Raises UndeterminedOffsetError for a motion of constant speed, a motion that repeats, and logs
    that are too short, do not overlap or do not match.
    """
    coarse = _coarse(reference_time_s, reference_turns, time_s, turns)
    offset, _ = _fine(reference_time_s, reference_turns, time_s, turns, coarse)
    edges = np.linspace(reference_time_s[0], reference_time_s[-1], PARTS + 1)
    middles, offsets = [], []
    for low, high in pairwise(edges):
        part = (reference_time_s >= low) & (reference_time_s <= high)
        try:
            own, _ = _fine(reference_time_s[part], reference_turns[part], time_s, turns, offset)
        except UndeterminedOffsetError:
            continue
        middles.append(0.5 * (low + high))
        offsets.append(own)
    left = np.array(offsets) - offset
    if left.size < 3:
        return ClockOffset(offset, float("nan"), float("nan"), float("nan"), float("nan"))
    at = np.array(middles) - np.mean(middles)
    slope = float(at @ left / (at @ at))
    rest = left - left.mean() - slope * at
    scatter = float(np.sqrt(rest @ rest / (left.size - 2)))
    return ClockOffset(
        offset,
        float(left.std(ddof=1) / np.sqrt(left.size)),
        1e6 * slope,
        1e6 * scatter / float(np.sqrt(at @ at)),
        float(np.abs(left).max()),
    )


def _speed(time_s: Float, turns: Float, grid: Float) -> Float:
    return np.gradient(np.interp(grid, time_s, turns), grid)


def _coarse(reference_time_s: Float, reference_turns: Float, time_s: Float, turns: Float) -> float:
    """Return the time lag at which the speeds of the two logs have the highest
    cross-correlation."""
    shortest = min(np.ptp(reference_time_s), np.ptp(time_s))
    step = max(
        float(np.median(np.diff(reference_time_s))),
        float(np.median(np.diff(time_s))),
        max(np.ptp(reference_time_s), np.ptp(time_s)) / LARGEST_GRID,
    )
    if shortest < 8 * step:
        raise UndeterminedOffsetError("one of the logs is too short to determine the clock offset")
    ours = np.arange(time_s[0], time_s[-1], step)
    theirs = np.arange(reference_time_s[0], reference_time_s[-1], step)
    speed, reference_speed = (
        _speed(time_s, turns, ours),
        _speed(reference_time_s, reference_turns, theirs),
    )
    for one in (speed, reference_speed):
        if float(one.std()) < LEAST_VARIATION * float(np.abs(one).mean()):
            raise UndeterminedOffsetError(
                "the table moves at constant speed, which does not determine the clock offset"
            )
    first, second = speed - speed.mean(), reference_speed - reference_speed.mean()
    size = 1 << int(np.ceil(np.log2(first.size + second.size)))
    product = np.fft.irfft(
        np.fft.rfft(first, size) * np.conj(np.fft.rfft(second, size)), size
    ) / np.sqrt((first @ first) * (second @ second))
    # The absolute value is used, because encoder and reference may count in opposite directions.
    match = np.abs(product)
    best = int(np.argmax(match))
    longest = max(first.size, second.size) / min(first.size, second.size)
    if match[best] * np.sqrt(longest) < LEAST_MATCH:
        raise UndeterminedOffsetError(
            f"the logs do not match: the correlation of their speeds is {match[best]:.2f} at most"
        )

    def lag_s(place: int) -> float:
        lag = place if place < size // 2 else place - size
        return float(ours[0] + lag * step - theirs[0])

    # Before the search for a second peak, remove the highest peak on both sides down to half its
    # height.
    clear = match.copy()
    for way in (1, -1):
        place = best
        while match[place % size] > 0.5 * match[best] and abs(place - best) < size // 2:
            clear[place % size] = 0.0
            place += way
    rival = int(np.argmax(clear))
    if clear[rival] > RIVAL * match[best]:
        raise UndeterminedOffsetError(
            "the motion repeats, and several offsets fit equally well", (lag_s(best), lag_s(rival))
        )
    return lag_s(best)


def _fine(
    reference_time_s: Float,
    reference_turns: Float,
    time_s: Float,
    turns: Float,
    start_s: float,
) -> tuple[float, float]:
    """Return the clock offset by the Gauss–Newton method, and its standard uncertainty from the
    residuals."""
    offset, sigma = start_s, float("nan")
    speed = np.gradient(turns, time_s)
    sign = 0.0
    for _ in range(30):
        at = reference_time_s + offset
        inside = (at > time_s[0]) & (at < time_s[-1])
        if int(inside.sum()) < 8:
            raise UndeterminedOffsetError("the logs do not overlap")
        read = np.interp(at[inside], time_s, turns)
        rate = np.interp(at[inside], time_s, speed)
        reference = reference_turns[inside]
        if sign == 0.0:
            sign = float(np.sign((read - read.mean()) @ (reference - reference.mean()))) or 1.0
        rest = read - sign * reference
        rest = rest - rest.mean()
        varying = rate - rate.mean()
        power = float(varying @ varying)
        if power <= (LEAST_VARIATION**2) * float(rate @ rate):
            raise UndeterminedOffsetError(
                "the table moves at constant speed, which does not determine the clock offset"
            )
        step = -float(varying @ rest) / power
        sigma = float(np.sqrt(rest @ rest / rest.size / power))
        offset += step
        if abs(step) < 1e-9:
            break
    return offset, sigma
