"""Surrogates of the residuals: whole revolutions shifted circularly, cycles exchanged.

They keep what is alike from sample to sample (the noise's own correlation) and lose every tie to
the angle, the time and the run, so that a scan of a surrogate shows what chance alone gives.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.observations import CaptureRows, ReferenceRows

Float = NDArray[np.float64]
LEAST_CYCLES = 4


def _groups(labels: NDArray[np.int64]) -> list[slice]:
    edges = np.flatnonzero(np.diff(labels)) + 1
    bounds = [0, *edges.tolist(), labels.size]
    return [slice(start, end) for start, end in pairwise(bounds)]


def capture_groups(rows: CaptureRows) -> list[slice]:
    """The rows of each revolution."""
    return _groups(rows.revolution)


def reference_groups(rows: ReferenceRows) -> list[slice]:
    """The rows of each cycle (or run); of one long run pieces stand in for the cycles."""
    groups = _groups(rows.run if rows.cycle is None else rows.cycle)
    if len(groups) >= LEAST_CYCLES:
        return groups
    size = rows.run.size
    pieces = max(LEAST_CYCLES, min(16, size // 8))
    bounds = np.linspace(0, size, pieces + 1).astype(int)
    return [slice(start, end) for start, end in pairwise(bounds.tolist()) if end > start]


def capture_surrogates(
    rows: CaptureRows, residual: Float, count: int, random: np.random.Generator
) -> Iterator[Float]:
    """``count`` surrogates of the capture's residual, each of shape (rows,).

    Each revolution is shifted by a random number of samples and its sign is drawn: the noise is
    as likely one way as the other.
    """
    return _surrogates(capture_groups(rows), residual, count, random)


def reference_surrogates(
    rows: ReferenceRows, residual: Float, count: int, random: np.random.Generator
) -> Iterator[Float]:
    """``count`` surrogates of the reference's residual, each of shape (rows,).

    Rows are shifted circularly within each cycle (or run), and the sign of a cycle is drawn.
    """
    return _surrogates(reference_groups(rows), residual, count, random)


def _surrogates(
    groups: list[slice], residual: Float, count: int, random: np.random.Generator
) -> Iterator[Float]:
    for _ in range(count):
        surrogate = np.empty_like(residual)
        for group in groups:
            length = group.stop - group.start
            shifted = np.roll(residual[group], int(random.integers(length)))
            surrogate[group] = shifted if random.random() < 0.5 else -shifted
        yield surrogate


def mean_square_moment(groups: list[slice], residual: Float, columns: Float) -> Float:
    """Mean of m·mᵀ, m = columnsᵀ·surrogate, over every surrogate there is, shape (width, width).

    ``columns`` has shape (rows, width). Signs are drawn for themselves, so that no two groups
    have a part in common on average; the mean over all shifts of a group is, by Parseval's
    theorem, Σ|R|²·W·W*/n² over the frequencies of its residual R and its columns W.
    """
    total = np.zeros((columns.shape[1], columns.shape[1]))
    for group in groups:
        length = group.stop - group.start
        power = np.abs(np.fft.rfft(residual[group])) ** 2
        waves = np.fft.rfft(columns[group], axis=0)
        # A frequency and its negative, but for zero and the half of the sample rate.
        power[1 : (length + 1) // 2] *= 2.0
        total += np.real(waves.T @ (power[:, np.newaxis] * waves.conj())) / length**2
    return total
