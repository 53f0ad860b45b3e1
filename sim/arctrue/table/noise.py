"""Describes Gaussian noise over time: the form in which a cause states it, its draws, and its
covariance."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_banded

Float = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Noise:
    """Gaussian noise of mean zero in ``n`` rows in order of time.

    The noise is the sum of white noise with the standard deviation ``white_rad`` ``(n,)`` and of
    ``k`` first-order Gauss–Markov processes. Process j has the standard deviation ``sigma_rad[j]``
    and the correlation ``decay[j, i]`` between row i − 1 and row i, so that cov(i, l) =
    white_i²·δ_il + Σ_j sigma_j²·Π_{i < m ≤ l} decay_jm.

    Each process is computed from row to row, not by a Fourier series, so that the end of a run is
    not correlated with its beginning.
    """

    white_rad: Float
    sigma_rad: Float
    """Standard deviation of each process, shape ``(k,)``."""
    decay: Float
    """Correlation of each row with the previous one, shape ``(k, n)``, |decay| ≤ 1. Column 0 is not
    used, because each process is stationary from the first row on."""

    @classmethod
    def white(cls, sigma_rad: Float | float, rows: int) -> Noise:
        """Return independent noise with one standard deviation for all rows, or with one for each
        row."""
        return cls(np.broadcast_to(np.asarray(sigma_rad, float), rows), np.zeros(0), _none(rows))

    @classmethod
    def relaxing(cls, sigma_rad: Float, constant_s: Float, time_s: Float) -> Noise:
        """Return Ornstein–Uhlenbeck processes with these standard deviations and time constants
        ``(k,)``."""
        steps = np.concatenate([[0.0], np.maximum(np.diff(time_s), 0.0)])
        decay = np.exp(-steps / np.asarray(constant_s)[:, None])
        return cls(np.zeros(time_s.size), np.asarray(sigma_rad, float), decay)

    def draw(self, random: np.random.Generator) -> Float:
        """Return one random realisation, radians, shape ``(n,)``."""
        found = self.white_rad * random.standard_normal(self.white_rad.size)
        for sigma, decay in zip(self.sigma_rad, self.decay, strict=True):
            found = found + sigma * _gauss_markov(decay, random)
        return found

    def rows(self, kept: NDArray[np.bool_]) -> Noise:
        """Return the noise of the rows where ``kept`` is true. The decay of a kept row becomes the
        product of its own decay and those of the omitted rows before it."""
        at = np.flatnonzero(kept)
        running = np.cumsum(np.log(np.maximum(np.abs(self.decay), 1e-300)), axis=1)
        signs = np.cumprod(np.where(self.decay < 0, -1.0, 1.0), axis=1)
        size = np.exp(np.diff(running[:, at], axis=1, prepend=running[:, at[:1]]))
        sign = signs[:, at] * np.concatenate([signs[:, at[:1]], signs[:, at[:-1]]], axis=1)
        return Noise(self.white_rad[kept], self.sigma_rad, size * sign)

    def covariance(self) -> Float:
        """Return the covariance as a full matrix ``(n, n)``, rad²; it is meant for small n."""
        found = np.diag(self.white_rad**2)
        for sigma, decay in zip(self.sigma_rad, self.decay, strict=True):
            link = np.eye(decay.size)
            for column in range(1, decay.size):
                link[:column, column] = link[:column, column - 1] * decay[column]
            found += sigma**2 * (link + link.T - np.eye(decay.size))
        return found


def together(parts: Iterable[Noise], rows: int) -> Noise:
    """Return the sum of independent noises of the same rows; processes with equal decay are
    combined into one."""
    variance = np.zeros(rows)
    processes: dict[bytes, tuple[float, Float]] = {}
    for part in parts:
        variance = variance + part.white_rad**2
        for sigma, decay in zip(part.sigma_rad, part.decay, strict=True):
            before, _ = processes.get(decay.tobytes(), (0.0, decay))
            processes[decay.tobytes()] = (before + float(sigma) ** 2, decay)
    return Noise(
        np.sqrt(variance),
        np.sqrt(np.array([square for square, _ in processes.values()])),
        np.array([decay for _, decay in processes.values()]).reshape(-1, rows),
    )


def _none(rows: int) -> Float:
    return np.zeros((0, rows))


def _gauss_markov(decay: Float, random: np.random.Generator) -> Float:
    """Compute x_i = decay_i·x_{i−1} + sqrt(1 − decay_i²)·w_i, which has the variance 1 in every
    row."""
    fresh = np.sqrt(1.0 - decay**2)
    fresh[0] = 1.0
    drive = fresh * random.standard_normal(decay.size)
    band = np.stack([np.ones_like(decay), np.append(-decay[1:], 0.0)])
    return np.asarray(solve_banded((1, 0), band, drive))
