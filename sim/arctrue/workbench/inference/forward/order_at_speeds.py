"""Tests whether a line over time is an order whose size differs between runs of different speed.

If an order grows with the speed, the runs of one speed can have most of the rows. Over time, the
order is then a line with the frequency that it has at this speed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.forward.record import Record, orthonormal
from arctrue.workbench.inference.forward.search import LineSearch

Float = NDArray[np.float64]

ANOTHER_SPEED = 1.2
"""Smallest ratio of two speeds that count as different. A line of four periods or more then has
another frequency in the runs of the other speed."""
TRIED = np.linspace(-1.0, 1.0, 9)
"""Offsets at which orders and frequencies are tried around the line's, in periods over a stretch.
Neighbouring offsets differ by a quarter of a period: half an interval costs at most 3 % of the
amplitude."""
MOST_STRETCHES = 24
"""Largest number of stretches that are compared, the longest of each speed, to limit cost: each
adds two columns to every model that is tried."""
CONTRADICTS = 6.0
"""Twice the log likelihood ratio above which the rows contradict the line: odds of 20 to 1, the
same as between an effect and a product of parts."""


def is_an_order(found: LineSearch, rate: float, of_angle: Record) -> bool:
    """Tell whether an order explains the line of ``found``, a search over time, in place of a
    frequency.

    Two tests are necessary. With a size and a phase for each stretch, an order explains more than a
    frequency. And with this order in the model, the rows contradict a line of the size that was
    found: without a line they are more likely. ``of_angle``: the same rows over the angle.
    """
    record = found.record
    number = [record.stretch == one for one in np.unique(record.stretch)]
    lengths = [(float(np.ptp(of_angle.place[own])), _length(record, own)) for own in number]
    if min(length for _, length in lengths) <= 0.0 or min(way for way, _ in lengths) <= 0.0:
        return False
    speeds = np.array([way / length for way, length in lengths])
    if speeds.max() < ANOTHER_SPEED * speeds.min():
        return False
    chosen = _longest_of_each_speed(speeds, lengths)
    speeds = speeds[chosen]
    number, lengths = [number[one] for one in chosen], [lengths[one] for one in chosen]
    others = record.columns(np.array([line.rate for line in found.lines if line.rate != rate]))
    rows = record.rows(others)
    factor = rows.factor(found.noise.noise)
    whitened = factor.whiten(rows.values)
    base, measured = orthonormal([whitened[:, 1:]]), whitened[:, 0]
    mask = np.column_stack(number).astype(np.float64)

    def waves(columns: Float) -> Float:
        own = (columns[:, :, np.newaxis] * mask[:, np.newaxis]).reshape(measured.size, -1)
        own = factor.whiten(own)
        return np.hstack([base, orthonormal([own - base @ (base.T @ own)])])

    def explained(model: Float) -> float:
        return float(np.sum((model.T @ measured) ** 2))

    longest = max(length for _, length in lengths)
    of_time = max(explained(waves(record.line_columns(rate + away / longest))) for away in TRIED)
    orders = [
        waves(of_angle.line_columns(rate / speed + away / way))
        for speed, way in _different(speeds, lengths)
        for away in TRIED
    ]
    model = max(orders, key=explained)
    if explained(model) - of_time <= CONTRADICTS:
        return False
    line = factor.whiten(record.line_columns(rate) * mask.sum(axis=1)[:, np.newaxis])
    before, _ = _size(line, base, measured)
    after, information = _size(line, model, measured)
    away = after - before
    return float(away @ information @ away - after @ information @ after) > CONTRADICTS


def _length(record: Record, own: NDArray[np.bool_]) -> float:
    return float(np.ptp(record.place[own]))


def _groups(speeds: Float) -> list[NDArray[np.int64]]:
    """Return the numbers of the stretches of each different speed."""
    order = np.argsort(speeds)
    new = np.diff(speeds[order], prepend=0.0) > (ANOTHER_SPEED - 1.0) * speeds[order]
    return np.split(order, np.flatnonzero(new)[1:])


def _longest_of_each_speed(speeds: Float, lengths: list[tuple[float, float]]) -> list[int]:
    """Return the numbers of the longest stretches of each different speed, in their order."""
    groups = _groups(speeds)
    most = max(MOST_STRETCHES // len(groups), 1)
    longest = [sorted(group, key=lambda one: -lengths[one][0])[:most] for group in groups]
    return sorted(int(one) for group in longest for one in group)


def _different(speeds: Float, lengths: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return each different speed with the longest way of its stretches."""
    longest = [max(group, key=lambda one: lengths[one][0]) for group in _groups(speeds)]
    return [(float(speeds[one]), lengths[one][0]) for one in longest]


def _size(line: Float, model: Float, measured: Float) -> tuple[Float, Float]:
    """Return the two coefficients of a line beyond a model, and their information."""
    own = line - model @ (model.T @ line)
    information = own.T @ own
    return np.asarray(np.linalg.pinv(information) @ (own.T @ measured)), np.asarray(information)
