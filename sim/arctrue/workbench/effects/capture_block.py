"""Computes the columns of an effect on the rows of a capture with any number of heads.

:meth:`Effect.capture_columns` returns the contribution of an effect to Rᵢ − R₁ for one head i. With
two heads, these columns are used unchanged. With more heads, each row is a contrast of one head
with all heads before it, and this module combines the columns with the same weights.
"""

from __future__ import annotations

from weakref import WeakKeyDictionary

import numpy as np

from arctrue.workbench.effects.base import Columns, Effect, FitContext, Nonlinear
from arctrue.workbench.observations.rows import CaptureRows

_OF_HEADS: WeakKeyDictionary[CaptureRows, dict[int, CaptureRows]] = WeakKeyDictionary()
"""Rows of each head, for the rows of all channels."""


def _of_heads(rows: CaptureRows) -> dict[int, CaptureRows]:
    """Return the rows of each head. These objects are stored, so that an effect that keeps data for
    its rows gets the same object again."""
    if rows not in _OF_HEADS:
        _OF_HEADS[rows] = {head: rows.of_head(head) for head in range(2, rows.heads + 1)}
    return _OF_HEADS[rows]


def capture_block(
    effect: Effect, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
) -> Columns | None:
    """Return each coefficient's contribution to the measured rows, arcseconds; None: no
    contribution."""
    if rows.channel is None:
        return effect.capture_columns(rows, nonlinear, context)
    total: Columns | None = None
    weights = rows.weights
    for head, of_head in _of_heads(rows).items():
        columns = effect.capture_columns(of_head, nonlinear, context)
        if columns is None:
            continue
        weighted = weights[rows.channel, head - 2][:, np.newaxis] * columns
        total = weighted if total is None else total + weighted
    return total


def in_place_of_head(column: Columns, rows: CaptureRows) -> Columns:
    """Place the columns of head i among the columns of heads 2 … H; the columns of all other heads
    are 0.

    ``column`` has shape (rows, k); the result has k columns for each of heads 2 … H.
    """
    if rows.heads == 2:
        return column
    width = column.shape[1]
    found = np.zeros((column.shape[0], width * (rows.heads - 1)))
    start = width * (rows.head - 2)
    found[:, start : start + width] = column
    return found
