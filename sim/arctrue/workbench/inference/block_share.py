"""Calculates the share of an effect's own error that other blocks of the rows predict.

If the rows are closely spaced or the noise is slow, the neighbours of an omitted row predict this
row, so that single omitted rows do not test the effect. Here the runs, or the cycles of a
reference, are cut into a few long blocks. The model is projected out of the effect's columns over
all rows; then block b alone gives coefficients c_b, and the other blocks give c₋b. The share is 1 −
(Σ |A_b(c_b − c₋b)|² − its mean by noise)/(Σ |A_b·c_b|² − its mean by noise) over whitened rows A_b.
It is about 1 for an effect that is the same everywhere, and about 0 for noise of any spectrum.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.workbench.effects.base import Effect, Nonlinear
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.numeric.symmetric import RANK_TOLERANCE
from arctrue.workbench.observations import CaptureRows, ReferenceRows

BLOCKS = 6
"""Number of long blocks, a choice: with more than 8 blocks, a block would be too short."""
KNOWN_ELSEWHERE = 0.75
"""Largest share of the information about a direction that one block may have. If the share is
larger, the other blocks cannot predict the direction: the variance of their prediction would be 3
times the variance of the block's own estimate."""
MOST_ERRORS = 2.0
"""Smallest ratio of half the effect's own error to the standard deviation of the disagreement that
noise alone causes. With a smaller ratio, the test by blocks is not made, because it would refuse
more than 2.3 % of true effects.
"""
Float = NDArray[np.float64]
Integer = NDArray[np.int64]


@dataclass(frozen=True)
class BlockShare:
    """The share of an effect's own error that the other blocks predict."""

    share: float
    own: float
    """χ² of the effect's own error in the directions that several blocks determine, minus its mean
    by noise."""


def block_share(residuals: Residuals, effect: Effect, nonlinear: Nonlinear) -> BlockShare | None:
    """Return the share for an effect; ``residuals`` belong to the model without the effect.

    The result is None if blocks cannot test the effect.
    """
    score = residuals.score(effect, nonlinear)
    observations = residuals.observations
    size = score.moment.size
    information, moment = np.zeros((BLOCKS, size, size)), np.zeros((BLOCKS, size))
    for columns, left, rows in zip(
        residuals.projected_columns(effect, nonlinear, score),
        (residuals.capture_whitened, residuals.reference_whitened),
        (observations.capture, observations.reference),
        strict=True,
    ):
        if columns is None or left is None or rows is None:
            continue
        block = blocks_of(rows)
        for number in range(BLOCKS):
            inside = block == number
            own = columns[inside]
            information[number] += own.T @ own
            moment[number] += own.T @ left[inside]
    return share_of(information, moment)


def share_of(information: Float, moment: Float) -> BlockShare | None:
    """Return the share, given the normal matrices (blocks, q, q) and moments (blocks, q) of the
    blocks."""
    values, vectors = np.linalg.eigh(information.sum(axis=0))
    determined = values > RANK_TOLERANCE * max(float(values.max(initial=0.0)), 1e-300)
    if not determined.any():
        return None
    # In these coordinates the information of all blocks together is 1.
    into = vectors[:, determined] / np.sqrt(values[determined])
    total = into.T @ moment.sum(axis=0)
    own = mean_own = disagreement = mean_disagreement = variance = 0.0
    for of_block, moment_of_block in zip(information, moment, strict=True):
        share, basis = np.linalg.eigh(into.T @ of_block @ into)
        judged = (share > RANK_TOLERANCE) & (share < KNOWN_ELSEWHERE)
        share, basis = share[judged], basis[:, judged]
        here = basis.T @ (into.T @ moment_of_block)
        elsewhere = (basis.T @ total - here) / (1.0 - share)
        own += float(np.sum(here**2 / share))
        mean_own += share.size
        disagreement += float(np.sum(share * (here / share - elsewhere) ** 2))
        expected = 1.0 / (1.0 - share)
        mean_disagreement += float(np.sum(expected))
        variance += 2.0 * float(np.sum(expected**2))
    signal = own - mean_own
    if signal < 2.0 * MOST_ERRORS * np.sqrt(variance) or signal < 0.5 * float(total @ total):
        return None
    return BlockShare(1.0 - (disagreement - mean_disagreement) / signal, signal)


def blocks_of(rows: CaptureRows | ReferenceRows) -> Integer:
    """Return the number of each row's block, 0 … BLOCKS − 1; blocks are pieces of every run, or
    whole cycles."""
    cycle = rows.cycle if isinstance(rows, ReferenceRows) else None
    if cycle is not None:
        names, number = np.unique(cycle, return_inverse=True)
        if names.size >= BLOCKS:
            return np.asarray(number.reshape(-1) * BLOCKS // names.size, dtype=np.int64)
    found = np.zeros(rows.run.size, dtype=np.int64)
    for first, last in run_spans(rows.run):
        found[first:last] = np.arange(last - first) * BLOCKS // max(last - first, 1)
    return found
