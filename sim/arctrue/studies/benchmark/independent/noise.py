"""Defines the noise processes of the independent generator (this package): each process draws noise
and whitens columns (exactly, if the noise is normal and not rounded).

There are two kinds of processes. :class:`StateNoise` is a sum of white noise and linear Gaussian
states; a Kalman filter whitens it. :class:`FlickerNoise` is a fractional integral of white noise;
the inverse filter whitens it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.floating[Any]]
Random = np.random.Generator


class NoiseProcess(Protocol):
    """Process that generates the noise of one head or of the reference over all runs."""

    def draw(self, random: Random, time_s: Float) -> Float:
        """Draw noise in arcseconds at the given times, (n,)."""

    def whiten(self, columns: Float, time_s: Float) -> Float:
        """Return the innovations of columns (n, c) in units of their standard deviation."""

    def scaled(self, factor: float) -> NoiseProcess:
        """Return the same process with its standard deviation multiplied by ``factor``."""

    def with_white(self, sigma_arcsec: float) -> NoiseProcess:
        """Return the process plus independent white noise that models the rounding; use this sum
        for whitening and for the RMS, not for drawing."""

    def rms_arcsec(self, time_s: Float) -> float:
        """Return the expected standard deviation of a row; for a random walk, of its deviation from
        its mean over all rows."""

    @property
    def oscillators(self) -> tuple[DrivenOscillator, ...]:
        """Return the damped oscillators, driven by noise, that the process contains."""


@dataclass(frozen=True, slots=True)
class Relaxation:
    """Ornstein–Uhlenbeck process with the covariance σ²·exp(−|t|/τ)."""

    sigma_arcsec: float
    time_constant_s: float

    def start(self) -> Float:
        """Return the covariance of the state at the first row, (1, 1)."""
        return np.array([[self.sigma_arcsec**2]])

    def step(self, seconds: float) -> tuple[Float, Float]:
        """Return the state's transition matrix over ``seconds`` and the covariance of the added
        noise, both (1, 1)."""
        decay = float(np.exp(-seconds / self.time_constant_s))
        return np.array([[decay]]), np.array([[self.sigma_arcsec**2 * (1.0 - decay**2)]])


@dataclass(frozen=True, slots=True)
class RandomWalk:
    """Random walk that begins at zero and has the variance σ²·t."""

    sigma_arcsec_per_root_s: float

    def start(self) -> Float:
        """Return the covariance of the state at the first row, (1, 1)."""
        return np.zeros((1, 1))

    def step(self, seconds: float) -> tuple[Float, Float]:
        """Return the state's transition matrix over ``seconds`` and the covariance of the added
        noise, both (1, 1)."""
        return np.eye(1), np.array([[self.sigma_arcsec_per_root_s**2 * seconds]])


@dataclass(frozen=True, slots=True)
class DrivenOscillator:
    """Damped oscillator that white noise drives: x″ + 2γx′ + ω₀²x = w, γ = ω₀/(2·Q), Q > ½.

    The state is (x, x′); its stationary covariance is diag(σ², σ²ω₀²).
    """

    sigma_arcsec: float
    hz: float
    quality: float

    def start(self) -> Float:
        """Return the stationary covariance, (2, 2)."""
        return np.diag([self.sigma_arcsec**2, (self.sigma_arcsec * 2 * np.pi * self.hz) ** 2])

    @property
    def half_width_hz(self) -> float:
        """Return the half width at half power, γ/(2π)."""
        return self.hz / (2 * self.quality)

    def step(self, seconds: float) -> tuple[Float, Float]:
        """Return the state's transition matrix over ``seconds``, a matrix exponential, and the
        covariance of the added noise, both (2, 2)."""
        natural = 2 * np.pi * self.hz
        damping = natural / (2 * self.quality)
        rate = float(np.sqrt(natural**2 - damping**2))
        cosine, sine = np.cos(rate * seconds), np.sin(rate * seconds) / rate
        move = np.exp(-damping * seconds) * np.array(
            [[cosine + damping * sine, sine], [-(natural**2) * sine, cosine - damping * sine]]
        )
        whole = self.start()
        return move, whole - move @ whole @ move.T


State = Relaxation | RandomWalk | DrivenOscillator


@dataclass(frozen=True)
class StateNoise:
    """White noise with a normal or a Student's t distribution, plus any number of noise states
    (such as Relaxation)."""

    white_arcsec: float
    states: tuple[State, ...] = ()
    freedom: float = float("inf")
    """Degrees of freedom (above 2) of the Student's t distribution of the white noise, whose
    standard deviation is ``white_arcsec``; ``inf`` gives a normal distribution."""

    def draw(self, random: Random, time_s: Float) -> Float:
        """Draw white noise plus all states, each driven by its own noise, (n,)."""
        if np.isinf(self.freedom):
            found = self.white_arcsec * random.standard_normal(time_s.size)
        else:
            scale = self.white_arcsec * np.sqrt((self.freedom - 2.0) / self.freedom)
            found = scale * random.standard_t(self.freedom, time_s.size)
        for state in self.states:
            found += _driven(state, random, time_s)
        return found

    def whiten(self, columns: Float, time_s: Float) -> Float:
        """Return the innovations of the columns in a Kalman filter that runs over the rows.

        The filter treats Student's t noise as normal noise with the same Fisher information about a
        shift: its variance is scale²·(ν + 3)/(ν + 1).
        """
        white = self.white_arcsec**2
        if np.isfinite(self.freedom):
            white *= (self.freedom - 2) / self.freedom * (self.freedom + 3) / (self.freedom + 1)
        if not self.states:
            white_rows: Float = columns / np.sqrt(white)
            return white_rows
        return _innovations(columns, time_s, self.states, white)

    def scaled(self, factor: float) -> StateNoise:
        """Return the process with every part multiplied by ``factor``."""
        return StateNoise(
            self.white_arcsec * factor,
            tuple(_scaled(state, factor) for state in self.states),
            self.freedom,
        )

    def with_white(self, sigma_arcsec: float) -> StateNoise:
        """Return the process with ``sigma_arcsec``² added to the variance of its white part."""
        return replace(self, white_arcsec=float(np.hypot(self.white_arcsec, sigma_arcsec)))

    def rms_arcsec(self, time_s: Float) -> float:
        """Compute the RMS from the covariances of the parts.

        A random walk over the duration T contributes σ²·T/6, its variance about its mean.
        """
        variance = self.white_arcsec**2
        for state in self.states:
            if isinstance(state, RandomWalk):
                variance += state.sigma_arcsec_per_root_s**2 * float(np.ptp(time_s)) / 6
            else:
                variance += state.sigma_arcsec**2
        return float(np.sqrt(variance))

    @property
    def oscillators(self) -> tuple[DrivenOscillator, ...]:
        """Return the damped oscillators among the states."""
        return tuple(state for state in self.states if isinstance(state, DrivenOscillator))

    def mean_periodogram(self, rows: int, step_s: float) -> Float:
        """Return the mean of |Σ x_n·e^(−2πikn/N)|²/N at k = 1 … ⌈N/2⌉ − 1 for N evenly spaced rows.

        The mean is Σ_l (1 − |l|/N)·C(l)·e^(−2πikl/N), with the covariance C(l) at the lag l. Raises
        ValueError for a random walk, which has no such mean.
        """
        covariance = np.zeros(rows)
        covariance[0] = self.white_arcsec**2
        for state in self.states:
            if isinstance(state, RandomWalk):
                raise ValueError("a random walk has no covariance that depends on the lag alone")
            move, at = state.step(step_s)[0], state.start()
            for lag in range(rows):
                covariance[lag] += at[0, 0]
                at = move @ at
        weighted = covariance * (1.0 - np.arange(rows) / rows)
        power: Float = 2.0 * np.fft.rfft(weighted).real - weighted[0]
        return power[1 : (rows + 1) // 2]


@dataclass(frozen=True)
class FlickerNoise:
    """1/f^a noise, 0 < a ≤ 1, made by fractional integration of white noise (Kasdin 1995); the unit
    of f is 1/row."""

    innovation_arcsec: float
    exponent: float
    white_arcsec: float = 0.0
    """Standard deviation of rounding noise. The variance of this noise is added to the variance of
    the innovations, which makes the oracle's sensitivity a little too low."""

    def draw(self, random: Random, time_s: Float) -> Float:
        """Filter white noise with (1 − z⁻¹)^(−a/2), (n,)."""
        white = self.innovation_arcsec * random.standard_normal((time_s.size, 1))
        return _filtered(white, self.exponent / 2)[:, 0]

    def whiten(self, columns: Float, time_s: Float) -> Float:
        """Filter the columns with (1 − z⁻¹)^(a/2)."""
        sigma = float(np.hypot(self.innovation_arcsec, self.white_arcsec))
        return _filtered(columns, -self.exponent / 2) / sigma

    def scaled(self, factor: float) -> FlickerNoise:
        """Return the process with innovations and rounding noise multiplied by ``factor``."""
        return replace(
            self,
            innovation_arcsec=self.innovation_arcsec * factor,
            white_arcsec=self.white_arcsec * factor,
        )

    def with_white(self, sigma_arcsec: float) -> FlickerNoise:
        """Return the process with rounding noise of the standard deviation ``sigma_arcsec``
        added."""
        return replace(self, white_arcsec=float(np.hypot(self.white_arcsec, sigma_arcsec)))

    def rms_arcsec(self, time_s: Float) -> float:
        """Compute the RMS from the squares of the impulse response, averaged over the rows."""
        response = _response(time_s.size, self.exponent / 2)
        grown = np.cumsum(response**2)
        return float(np.hypot(self.innovation_arcsec * np.sqrt(grown.mean()), self.white_arcsec))

    @property
    def oscillators(self) -> tuple[DrivenOscillator, ...]:
        """Return no oscillators, because the process has no time constant."""
        return ()


def any_noise(random: Random, sigma_arcsec: float, length_s: float, step_s: float) -> StateNoise:
    """Draw one of five kinds of noise: white alone, white with a relaxation, with a random walk or
    with both, or white with heavy tails."""
    kind = int(random.integers(5))
    tau_s = float(np.exp(random.uniform(np.log(5 * step_s), np.log(length_s / 5))))
    relaxation = Relaxation(sigma_arcsec * random.uniform(0.3, 1.0), tau_s)
    walk = RandomWalk(sigma_arcsec * random.uniform(0.5, 2.0) / np.sqrt(length_s))
    states: Sequence[State] = ((), (relaxation,), (walk,), (relaxation, walk), ())[kind]
    freedom = float(random.uniform(3, 6)) if kind == 4 else float("inf")
    return StateNoise(sigma_arcsec, tuple(states), freedom)


def _scaled(state: State, factor: float) -> State:
    if isinstance(state, RandomWalk):
        return RandomWalk(state.sigma_arcsec_per_root_s * factor)
    return replace(state, sigma_arcsec=state.sigma_arcsec * factor)


def _driven(state: State, random: Random, time_s: Float) -> Float:
    at = _root(state.start()) @ random.standard_normal(len(state.start()))
    kicks = random.standard_normal((time_s.size, at.size))
    found = np.empty(time_s.size)
    steps: dict[float, tuple[Float, Float]] = {}
    for row, seconds in enumerate(_seconds(time_s)):
        if row:
            if seconds not in steps:
                move, added = state.step(seconds)
                steps[seconds] = move, _root(added)
            move, root = steps[seconds]
            at = move @ at + root @ kicks[row]
        found[row] = at[0]
    return found


def _innovations(
    columns: Float, time_s: Float, states: Sequence[State], white_arcsec2: float
) -> Float:
    sizes = [len(state.start()) for state in states]
    begins = np.cumsum([0, *sizes])
    seen = np.zeros(begins[-1])
    seen[begins[:-1]] = 1.0
    spread = _blocks([state.start() for state in states])
    expected = np.zeros((begins[-1], columns.shape[1]))
    found = np.empty_like(columns)
    steps: dict[float, tuple[Float, Float]] = {}
    for row, seconds in enumerate(_seconds(time_s)):
        if row:
            if seconds not in steps:
                pairs = [state.step(seconds) for state in states]
                steps[seconds] = _blocks([p[0] for p in pairs]), _blocks([p[1] for p in pairs])
            move, added = steps[seconds]
            expected = move @ expected
            spread = move @ spread @ move.T + added
        shared = spread @ seen
        variance = seen @ shared + white_arcsec2
        new = columns[row] - seen @ expected
        found[row] = new / np.sqrt(variance)
        gain = shared / variance
        expected = expected + np.outer(gain, new)
        spread = spread - np.outer(gain, shared)
    return found


def _seconds(time_s: Float) -> list[float]:
    """Return the time step before each row, rounded to the nanosecond so that equal steps share one
    transition matrix."""
    steps: list[float] = np.round(np.diff(time_s, prepend=time_s[:1]), 9).tolist()
    return steps


def _blocks(parts: Sequence[Float]) -> Float:
    size = sum(len(part) for part in parts)
    found = np.zeros((size, size))
    at = 0
    for part in parts:
        found[at : at + len(part), at : at + len(part)] = part
        at += len(part)
    return found


def _root(covariance: Float) -> Float:
    values, vectors = np.linalg.eigh(covariance)
    root: Float = vectors * np.sqrt(np.clip(values, 0.0, None))
    return root


def _response(rows: int, power: float) -> Float:
    """Return the impulse response of (1 − z⁻¹)^(−power).

    h₀ = 1, h_k = h_{k−1}·(k − 1 + power)/k.
    """
    at = np.arange(1, rows)
    return np.concatenate([[1.0], np.cumprod((at - 1 + power) / at)])


def _filtered(columns: Float, power: float) -> Float:
    rows = len(columns)
    size = 1 << (2 * rows - 1).bit_length()
    response = np.fft.rfft(_response(rows, power), size)[:, None]
    found: Float = np.fft.irfft(np.fft.rfft(columns, size, axis=0) * response, size, axis=0)[:rows]
    return found
