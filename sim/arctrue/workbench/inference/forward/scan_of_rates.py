"""Gain of a line at each of many rates, with the noise unchanged, and the rate with the highest
gain near a given one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.record import Record
from arctrue.workbench.noise.kernel import KernelNoise

Float = NDArray[np.float64]

COLUMNS_TOGETHER = 400
"""Largest number of columns of one matrix product; it limits memory only."""


def scan(record: Record, rates: Float, others: Float, noise: KernelNoise) -> Float:
    """Return the rise of the log likelihood by a line at each rate, with the noise unchanged.

    The rise is multiplied by the line's share from :func:`own_shares`; shape (rates,).
    """
    found = np.zeros(rates.size)
    if rates.size == 0:
        return found
    rows = record.rows(others)
    factor = rows.factor(noise)
    whitened = factor.whiten(rows.values)
    vectors, values, _ = np.linalg.svd(whitened[:, 1:], full_matrices=False)
    model = vectors[:, values > 1e-9 * values[0]]
    own = whitened[:, 0] - model @ (model.T @ whitened[:, 0])
    together = COLUMNS_TOGETHER // 2
    for start in range(0, rates.size, together):
        part = slice(start, start + together)
        measured = record.columns(rates[part])
        columns = factor.whiten(measured)
        before = np.einsum("ij,ij->j", columns, columns)
        columns -= model @ (model.T @ columns)
        cosine, sine = columns[:, 0::2], columns[:, 1::2]
        cc, ss, cs = (
            np.einsum("ij,ij->j", left, right)
            for left, right in ((cosine, cosine), (sine, sine), (cosine, sine))
        )
        c, s = cosine.T @ own, sine.T @ own
        determinant = cc * ss - cs**2
        there = determinant > OWN_SHARE * before[0::2] * before[1::2]
        square = c**2 * ss - 2.0 * c * s * cs + s**2 * cc
        np.divide(0.5 * square, determinant, out=found[part], where=there)
        found[part] *= own_shares(record, measured)
    return found


OWN_SHARE = 1e-3
"""Smallest share of the squares of a line's columns that the base does not explain; with a smaller
share, the line belongs to the base."""


def own_shares(record: Record, columns: Float) -> Float:
    """Return the share of the squares of each line's columns that the base leaves; shape (lines,).

    A gain is multiplied by this share. If the base explains a part of a line, it has also absorbed
    that part of the noise, so that the noise is known less well. Without this factor, the part of a
    slow change that the base leaves would look like lines next to the table's orders, if the record
    is shorter than a turn. These lines would cancel the orders.
    """
    pairs = (-1, 2)
    made = np.sum((record.base.T @ columns) ** 2, axis=0).reshape(pairs).sum(axis=1)
    whole = np.sum(columns**2, axis=0).reshape(pairs).sum(axis=1)
    return np.asarray(np.maximum(1.0 - made / np.maximum(whole, 1e-300), 0.0))


def refined(record: Record, rate: float, others: Float, noise: KernelNoise) -> float:
    """Return the rate with the highest gain, at most half of 1/span from the given rate.

    The steps become finer than the uncertainty of the rate, which is 0.55/(span·√(2·gain)) for a
    line over the whole record. If the rate of a large line were not exact, other effects would
    explain the remaining error.
    """
    wide = 0.5 / record.span
    for number in range(MOST_REFINED):
        grid = rate + np.linspace(-wide, wide, 11)
        gains = scan(record, grid, others, noise)
        at = int(np.argmax(gains))
        rate = float(grid[at])
        wide /= 5.0
        sigma = 0.55 / (record.span * np.sqrt(2.0 * max(float(gains[at]), 1.0)))
        if number > 0 and wide < FINE * sigma:
            break
    return rate


MOST_REFINED = 8
"""Largest number of refinements of a rate; the last step is 10⁻⁶ of 1/span."""
FINE = 0.25
"""Step of the last refinement, in uncertainties of the rate: an error of half a step loses 1/128 of
a log likelihood."""


def moved_in_turn(record: Record, rates: Sequence[float], noise: KernelNoise) -> list[float]:
    """Move each line in turn to the rate with the highest gain, with all other lines in the
    model."""
    if record.whole_orders_only:
        return list(rates)
    found = list(rates)
    for at, rate in enumerate(rates):
        others = record.columns(np.array(found[:at] + found[at + 1 :]))
        found[at] = refined(record, rate, others, noise)
    return found
