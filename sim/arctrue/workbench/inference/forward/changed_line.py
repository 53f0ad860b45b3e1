"""Fits one line whose phase and size change at a few instants: the rival of lines that beat."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.record import Record
from arctrue.workbench.noise.kernel_fit import KernelFit, best_fit, usual_starts

Float = NDArray[np.float64]

EDGES = 32
"""Number of equal intervals into which the record is divided in the search for the instants, as in
the search for a line in a part of a record."""
STEPS = 16
"""Number of places on each side of an instant among which the instant is refined, within one
interval."""
OVERSAMPLED, WIDER = 4.0, 2.0
"""Number of rates per 1/span in the search for the changed line, and the reach of this search below
the lowest and above the highest of the lines that beat, in units of 1/span. A line whose phase
flips has its power on both sides of its own rate."""


def changed_line(
    record: Record, others: Float, rates: tuple[float, float], parts: int, near: KernelFit
) -> KernelFit:
    """Return the noise with a line in the model that has another phase and size in each of
    ``parts`` parts of the record.

    ``others``: columns of the other lines; ``rates``: lowest and highest rate of the search;
    ``near``: noise from which the fit starts. Rate and instants are those that explain most in
    white noise.
    """
    left = record.rows(others).left()
    low, high = (rates[0] - WIDER / record.span, rates[1] + WIDER / record.span)
    count = int((high - low) * record.span * OVERSAMPLED) + 1
    edges = np.linspace(0, left.size, EDGES + 1).astype(np.int64)
    best, rate, cuts = -1.0, rates[0], [0, left.size]
    for tried in np.linspace(max(low, 0.1 * rates[0]), high, count).tolist():
        sums = _sums(record, left, tried)
        gain, found = _best_cuts(sums[edges], edges, parts)
        if gain > best:
            best, rate, cuts = gain, tried, found
    cuts = _refined(_sums(record, left, rate), cuts)
    wave = record.line_columns(rate)
    pieces = np.zeros((left.size, 2 * (len(cuts) - 1)))
    for at, (start, end) in enumerate(pairwise(cuts)):
        pieces[start:end, 2 * at : 2 * at + 2] = wave[start:end]
    rows = record.rows(np.hstack([others, pieces]))
    return best_fit(rows, [near.noise, *usual_starts(rows)])


def _sums(record: Record, left: Float, rate: float) -> Float:
    """Return the sums of cos and sin times the residuals before each row, shape (rows + 1, 2)."""
    products = record.line_columns(rate) * left[:, np.newaxis]
    return np.vstack([np.zeros(2), np.cumsum(products, axis=0)])


def _best_cuts(sums: Float, edges: NDArray[np.int64], parts: int) -> tuple[float, list[int]]:
    """Return the largest power of a line in ``parts`` parts between edges, and these edges."""
    own = sums[np.newaxis] - sums[:, np.newaxis]
    rows = edges[np.newaxis] - edges[:, np.newaxis]
    # In a part of whole periods, cosine and sine are orthogonal, each of the square rows/2.
    power = np.where(rows > 0, np.sum(own**2, axis=-1) / np.maximum(rows, 1), -np.inf)
    total, before = power[0], []
    for _ in range(parts - 1):
        every = total[:, np.newaxis] + power
        before.append(np.argmax(every, axis=0))
        total = np.max(every, axis=0)
    at = edges.size - 1
    found = [int(edges[at])]
    for last in reversed(before):
        at = int(last[at])
        found.append(int(edges[at]))
    return float(total[-1]), [0, *reversed(found)]


def _refined(sums: Float, cuts: list[int]) -> list[int]:
    """Move each instant in turn to the row with the largest power of both neighbouring parts."""
    size = sums.shape[0] - 1
    shifts = np.linspace(-size / EDGES, size / EDGES, 2 * STEPS + 1).astype(np.int64)
    found = list(cuts)
    for at in range(1, len(found) - 1):
        low, high = found[at - 1], found[at + 1]
        places = np.unique(np.clip(found[at] + shifts, low + 1, high - 1))
        before = np.sum((sums[places] - sums[low]) ** 2, axis=1) / (places - low)
        after = np.sum((sums[high] - sums[places]) ** 2, axis=1) / (high - places)
        found[at] = int(places[np.argmax(before + after)])
    return found
