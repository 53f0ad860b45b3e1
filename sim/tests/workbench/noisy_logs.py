"""Simulates logs that contain noise of many kinds and regular lines (sine waves in time).

The module uses plain numpy, and draws no noise from a kernel of the workbench.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]
Draw = Callable[[np.random.Generator, Float], Float]


def ornstein_uhlenbeck(random: np.random.Generator, time_s: Float, constant_s: float) -> Float:
    """Return Ornstein–Uhlenbeck noise with a standard deviation of one, exact over uneven steps."""
    kept = np.exp(-np.diff(time_s, prepend=time_s[0] - 1e9) / constant_s)
    found = np.zeros(time_s.size)
    drawn = random.normal(size=time_s.size)
    for row in range(time_s.size):
        before = found[row - 1] if row else 0.0
        found[row] = kept[row] * before + np.sqrt(1.0 - kept[row] ** 2) * drawn[row]
    return found


def driven_oscillator(
    random: np.random.Generator, time_s: Float, period_s: float, quality: float
) -> Float:
    """Return the motion of an oscillator that noise drives, x″ + (ω/Q)x′ + ω²x = noise, scaled to a
    standard deviation of one.

    The integration by Euler and Cromer has steps of at most a quarter of a row.
    """
    omega = 2.0 * np.pi / period_s
    span = float(time_s[-1] - time_s[0]) + 8.0 * quality * period_s / np.pi
    step = min(float(np.median(np.diff(time_s))) / 4.0, period_s / 60.0)
    count = int(span / step) + 2
    kicks = random.normal(size=count) * np.sqrt(step)
    place = speed = 0.0
    track = np.empty(count)
    for row, kick in enumerate(kicks.tolist()):
        speed += (-omega / quality * speed - omega**2 * place) * step + kick
        place += speed * step
        track[row] = place
    along = np.arange(count) * step - (count * step - float(time_s[-1] - time_s[0]))
    found = np.interp(time_s - time_s[0], along, track)
    return np.asarray(found / np.std(found))


def flicker(random: np.random.Generator, time_s: Float, slope: float) -> Float:
    """Return noise with a standard deviation of one and the density f^(−slope), from a Fourier
    transform over twice the length."""
    count = 2 * time_s.size
    frequency = np.fft.rfftfreq(count)
    frequency[0] = frequency[1]
    shaped = np.fft.rfft(random.normal(size=count)) * frequency ** (-slope / 2.0)
    found = np.fft.irfft(shaped, count)[: time_s.size]
    return np.asarray(found / np.std(found))


def walk(random: np.random.Generator, time_s: Float, freedom: float) -> Float:
    """Return a random walk with a standard deviation of one, whose steps have Student's t
    distribution.

    With a large ``freedom`` the walk is Brownian motion.
    """
    found = np.cumsum(random.standard_t(freedom, time_s.size))
    return np.asarray(found / np.std(found))


def moving_mean(random: np.random.Generator, time_s: Float, rows: int) -> Float:
    """Return white noise averaged over ``rows``, with a standard deviation of one; its density has
    zeros."""
    found = np.convolve(random.normal(size=time_s.size + rows - 1), np.ones(rows), mode="valid")
    return np.asarray(found / np.std(found))


def clock(random: np.random.Generator, rows: int, step_s: float, kind: str) -> Float:
    """Return the times of the rows: at even steps, with jitter, or with jitter and a pause of a
    tenth of the log."""
    time_s = np.arange(rows) * step_s
    if kind != "even":
        time_s = time_s + random.uniform(-0.3, 0.3, rows) * step_s
    if kind == "pause":
        time_s = time_s + np.where(np.arange(rows) > rows // 3, 0.1 * rows * step_s, 0.0)
    return np.asarray(time_s)


NULLS: dict[str, Draw] = {
    "white": lambda random, t: random.normal(size=t.size),
    "white, heavy tails": lambda random, t: random.standard_t(3.0, t.size),
    "OU 30 s": lambda random, t: (
        ornstein_uhlenbeck(random, t, 30.0) + 0.3 * random.normal(size=t.size)
    ),
    "OU 20 s and 400 s": lambda random, t: (
        ornstein_uhlenbeck(random, t, 20.0)
        + 2.0 * ornstein_uhlenbeck(random, t, 400.0)
        + 0.3 * random.normal(size=t.size)
    ),
    "random walk": lambda random, t: 8.0 * walk(random, t, 1e6) + 0.3 * random.normal(size=t.size),
    "walk, t with 3 degrees": lambda random, t: (
        8.0 * walk(random, t, 3.0) + 0.2 * random.normal(size=t.size)
    ),
    "walk, t with 2 degrees": lambda random, t: (
        8.0 * walk(random, t, 2.0) + 0.1 * random.normal(size=t.size)
    ),
    "critically damped 60 s": lambda random, t: (
        driven_oscillator(random, t, 60.0, 0.5) + 0.2 * random.normal(size=t.size)
    ),
    "resonance 90 s, Q 4": lambda random, t: (
        driven_oscillator(random, t, 90.0, 4.0) + 0.2 * random.normal(size=t.size)
    ),
    "resonance 120 s, Q 15": lambda random, t: (
        driven_oscillator(random, t, 120.0, 15.0) + 0.2 * random.normal(size=t.size)
    ),
    "two resonances": lambda random, t: (
        driven_oscillator(random, t, 40.0, 6.0)
        + driven_oscillator(random, t, 150.0, 8.0)
        + 0.2 * random.normal(size=t.size)
    ),
    "flicker 1/f": lambda random, t: flicker(random, t, 1.0),
    "flicker 1/f^1.6": lambda random, t: (
        3.0 * flicker(random, t, 1.6) + 0.1 * random.normal(size=t.size)
    ),
    "smooth 1/f^3": lambda random, t: (
        5.0 * flicker(random, t, 3.0) + 0.2 * random.normal(size=t.size)
    ),
    "moving mean of 12": lambda random, t: (
        moving_mean(random, t, 12) + 0.1 * random.normal(size=t.size)
    ),
    "OU that grows": lambda random, t: (
        np.linspace(0.4, 2.0, t.size) * ornstein_uhlenbeck(random, t, 40.0)
        + 0.3 * random.normal(size=t.size)
    ),
}
"""Functions that draw noise in arcseconds, without a line; one function for each kind of noise."""


def with_lines(time_s: Float, lines: Sequence[tuple[float, float]], phase: float = 0.4) -> Float:
    """Return the sum of a·cos(2πt/P + phase·k) over the lines, where line number k has (amplitude
    a, period P in seconds)."""
    found = np.zeros(time_s.size)
    for number, (amplitude, period_s) in enumerate(lines):
        found += amplitude * np.cos(2.0 * np.pi * time_s / period_s + phase * (1.0 + number))
    return found
