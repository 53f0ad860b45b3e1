"""Calculates which orders of the disc the heads at given places determine, and the noise of each
order.

At order n a head at the angle p from head 1 reads T + E·e^{jnp} + P·e^{jp} + Q·e^{−jp}: T is the
table's own motion, which is unknown; E is the disc's order; P and Q are the two circles of a motion
of the axis. L is the length of the part of the column e^{jnp} that is orthogonal to the columns of
T, P and Q. The noise of E is the noise of one head's line divided by L. At order 1 the forward
circle P equals the eccentricity of the disc; the backward circle does not.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

Float = NDArray[np.float64]
Integer = NDArray[np.int64]
MotionOrders = Literal["every"] | tuple[int, ...]
"""Orders at which the axis may move. ``every``: it may move at each order, and the motion may
differ from turn to turn."""

UNSEEN_GAIN = 1e3
"""Gain above which an order is treated as not determined. L is then 0.001, which is the change of L
that an error of 10″ in a place causes at order 20."""


def order_gain(places_rad: ArrayLike, orders: ArrayLike, motion: MotionOrders = ()) -> Float:
    """Return the ratio of the noise of E_n to the noise of one head, (…, orders) for places (…,
    heads); it is infinite for an order that the heads do not determine."""
    places = np.asarray(places_rad, dtype=np.float64)
    at = np.asarray(orders, dtype=np.int64)
    columns = np.exp(1j * places[..., None, :] * at[:, None])
    moving = np.ones(at.size, dtype=bool) if motion == "every" else np.isin(at, motion)
    forward = np.where((moving & (at != 1))[:, None], np.exp(1j * places)[..., None, :], 0.0)
    backward = np.where(moving[:, None], np.exp(-1j * places)[..., None, :], 0.0)
    basis: list[NDArray[np.complex128]] = []
    length = np.zeros(columns.shape[:-1])
    for other in (np.ones_like(columns), forward, backward, columns):
        left = np.asarray(other, dtype=np.complex128)
        # The projection is repeated, because classical Gram-Schmidt loses digits in the first
        # round.
        for _ in range(2):
            for known in basis:
                left = left - np.sum(known.conj() * left, axis=-1, keepdims=True) * known
        norm = np.linalg.norm(left, axis=-1, keepdims=True)
        basis.append(np.where(norm > 1e-9, left / np.maximum(norm, 1e-9), 0.0))
        length = norm[..., 0]
    seen = length > 1.0 / UNSEEN_GAIN
    return np.where(seen, 1.0 / np.where(seen, length, 1.0), np.inf)
