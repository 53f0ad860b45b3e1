"""Surrogates of the residuals: whole revolutions shifted circularly, cycles exchanged.

They keep what is alike from sample to sample (the noise's own correlation) and lose every tie to
the angle, the time and the run, so that a scan of a surrogate shows what chance alone gives.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from arctrue.observations import CaptureRows, ReferenceRows

Float = NDArray[np.float64]


def _groups(labels: NDArray[np.int64]) -> list[slice]:
    edges = np.flatnonzero(np.diff(labels)) + 1
    bounds = [0, *edges.tolist(), labels.size]
    return [slice(start, end) for start, end in pairwise(bounds)]


def capture_surrogates(
    rows: CaptureRows, residual: Float, count: int, random: np.random.Generator
) -> Iterator[Float]:
    """``count`` surrogates of the capture's residual, each of shape (rows,).

    Each revolution is shifted by a random number of samples and its sign is drawn: the noise is
    as likely one way as the other.
    """
    groups = _groups(rows.revolution)
    for _ in range(count):
        surrogate = np.empty_like(residual)
        for group in groups:
            length = group.stop - group.start
            shifted = np.roll(residual[group], int(random.integers(length)))
            surrogate[group] = shifted if random.random() < 0.5 else -shifted
        yield surrogate


def reference_surrogates(
    rows: ReferenceRows, residual: Float, count: int, random: np.random.Generator
) -> Iterator[Float]:
    """``count`` surrogates of the reference's residual, each of shape (rows,).

    Rows are shifted circularly within each cycle (or run), and the sign of a cycle is drawn.
    """
    labels = rows.run if rows.cycle is None else rows.cycle
    groups = _groups(labels)
    if len(groups) < 4:
        # One long run: pieces of it stand in for the cycles.
        pieces = max(4, min(16, residual.size // 8))
        bounds = np.linspace(0, residual.size, pieces + 1).astype(int)
        groups = [slice(a, b) for a, b in pairwise(bounds) if b > a]
    for _ in range(count):
        surrogate = np.empty_like(residual)
        for group in groups:
            length = group.stop - group.start
            shifted = np.roll(residual[group], int(random.integers(length)))
            surrogate[group] = shifted if random.random() < 0.5 else -shifted
        yield surrogate
