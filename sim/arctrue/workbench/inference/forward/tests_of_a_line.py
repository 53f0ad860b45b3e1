"""Tests whether a line (a sinusoidal error in a record) is the same in all blocks of the record,
and whether it is more than an oscillation driven by noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.record import Record
from arctrue.workbench.noise.kernel import KernelNoise
from arctrue.workbench.noise.kernel_fit import KernelFit, fit_from, with_oscillator

Float = NDArray[np.float64]

FAMILY_WISE = 0.01
"""Probability that noise alone gives at least one line in a record."""
LEAST_PERIODS, DECLARED_PERIODS = 4.0, 3.0
"""Fewest periods of a line in a record. A line with fewer periods counts as a slow change of
unknown form; 3 periods are enough if the set states the period."""
FEWEST_BLOCKS, MOST_BLOCKS = 3, 8
"""Smallest and largest number of blocks into which :func:`coherence` splits a record. A block lasts
at least one period, so only a declared line of fewer than 4 periods has 3 blocks.
"""


def needed_gain(gain: float, independent: float) -> float:
    """Return the gain in log likelihood that a line needs to be significant among ``independent``
    rates.

    In a record of noise, the largest gain among M independent rates and the rates between them
    exceeds Δ with the probability M·√(π·Δ/3)·e^(−Δ). This is the distribution of the maximum of a
    χ² field of two degrees of freedom (Davies, Biometrika 74 (1987) 33; Baluev, MNRAS 385 (2008)
    1279).
    """
    return float(np.log(independent / FAMILY_WISE) + 0.5 * np.log(np.pi * max(gain, 1.0) / 3.0))


@dataclass(frozen=True)
class Coherence:
    """The share of a line's own error that the other blocks of a record predict."""

    share: float
    """Share of the line's error in each block that the other blocks predict; 1 means the whole
    error."""
    taken_arcsec: float
    """RMS over all rows of the error that the prediction removes."""


def coherence(
    record: Record,
    columns: Float,
    others: Float,
    noise: KernelNoise,
    periods: float,
    *,
    along: Float | None = None,
) -> Coherence:
    """Return the share of a line that the other blocks predict; ``others`` are the columns of the
    other lines. ``along``: place of each row, from 0 to 1, by which the rows are divided into
    blocks; without it, the row number divided by the number of rows.

    Base and other lines are fitted to all rows, and are projected out of the columns (Frisch and
    Waugh): the part of the line that the base explains does not count as the line's error. Let c_b
    be the line's coefficients from block b alone, c₋ the line's coefficients from all other blocks,
    and A_b the columns of the line in block b. Both sets of coefficients are fitted together with
    the covariance of the noise, so that correlation across the edges counts. The share is

    1 − Σ|A_b(c_b − c₋)|²/Σ|A_b c_b|².
    """
    rows = record.rows(others)
    factor = rows.factor(noise)
    values = np.hstack([rows.values, columns])
    whitened = factor.whiten(values)
    width = columns.shape[1]
    known = slice(1, -width)
    both = np.column_stack([whitened[:, 0], whitened[:, -width:]])
    projected = np.linalg.lstsq(whitened[:, known], both, rcond=1e-10)[0]
    left = values[:, 0] - values[:, known] @ projected[:, 0]
    columns = columns - values[:, known] @ projected[:, 1:]
    count = int(np.clip(periods, FEWEST_BLOCKS, MOST_BLOCKS))
    if along is None:
        along = np.arange(left.size) / left.size
    number = np.minimum((along * count).astype(np.int64), count - 1)
    split = np.zeros((left.size, count * width))
    for block in range(count):
        own = number == block
        split[own, block * width : (block + 1) * width] = columns[own]
    both = factor.whiten(np.column_stack([left, split]))
    gram, moment = both[:, 1:].T @ both[:, 1:], both[:, 1:].T @ both[:, 0]
    own_square = missed = 0.0
    for block in range(count):
        here = slice(block * width, (block + 1) * width)
        into = np.zeros((count * width, 2 * width))
        for other in range(count):
            at = width if other == block else 0
            into[other * width : (other + 1) * width, at : at + width] = np.eye(width)
        normal = into.T @ gram @ into
        found = np.linalg.lstsq(normal, into.T @ moment, rcond=1e-12)[0]
        elsewhere, here_alone = found[:width], found[width:]
        inside = split[:, here]
        own_square += float(np.sum((inside @ here_alone) ** 2))
        missed += float(np.sum((inside @ (here_alone - elsewhere)) ** 2))
    taken = own_square - missed
    return Coherence(
        taken / max(own_square, 1e-300),
        float(np.sqrt(max(taken, 0.0) / np.sum(np.ones(left.size)))),
    )


def gain_over_an_oscillator(
    record: Record, line: Float, others: Float, rate: float, without: KernelFit, grown: KernelFit,
    enough: float,
) -> float:  # fmt: skip
    """Return the log likelihood that a line gains over an oscillator at its frequency.

    An oscillator driven by noise looks like a line that loses its phase; the oscillator that is
    fitted may keep its phase for a quarter of the record. ``without`` is the fit without the line,
    ``grown`` the fit with it. A result above ``enough`` is a lower bound, because the fit with the
    line then omits the oscillator.
    """
    rows = record.rows(others)
    both = record.rows(np.hstack([others, line]))
    found = 0.5 * (float(np.sum(rows.left() ** 2)) - float(np.sum(both.left() ** 2)))
    variance = max(found / rows.clock.size, 1e-30)
    rival = max(
        (
            fit_from(rows, with_oscillator(_kept(noise), rows, record.on_the_clock(rate), variance))
            for noise in (without.noise, grown.noise)
        ),
        key=lambda found: found.log_likelihood,
    )
    rival_likelihood = max(rival.log_likelihood, without.log_likelihood)
    if grown.log_likelihood - rival_likelihood > enough:
        return grown.log_likelihood - rival_likelihood
    with_both = fit_from(both, rival.noise)
    return max(with_both.log_likelihood, grown.log_likelihood) - rival_likelihood


def _kept(noise: KernelNoise) -> KernelNoise:
    """Return the noise without its negligible parts, because exact derivatives exist for up to four
    columns only."""
    largest = max((part.variance for part in noise.parts), default=0.0)
    parts = tuple(part for part in noise.parts if part.variance > NOTHING * largest)
    return KernelNoise(noise.white, parts)


NOTHING = 1e-5
"""A part of the noise is negligible if its variance is a smaller share than this of the largest
part's variance."""


def periods_in(record: Record, rate: float) -> float:
    """Return the number of periods of a line between the ends of the record."""
    return rate * record.span


def nearest(rates: Sequence[float], rate: float) -> float:
    """Return the distance from ``rate`` to the nearest of ``rates``; infinite if there are none."""
    return min((abs(rate - other) for other in rates), default=float("inf"))
