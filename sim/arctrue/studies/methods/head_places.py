"""What further read heads bring, and where: noise gain and blind orders of any set of places.

At one order n the heads at β_h show T + E·e^{−jnβ} (+ P·e^{jβ} + Q·e^{−jβ} where the axis moves):
the table's own motion T is unknown, E is wanted. What is left of the column e^{−jnβ} after the
others are projected out has the length L, and E has the noise of one head's line over L.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

UNSEEN_GAIN = 1e4


def gain_of_places(places_rad: Float, orders: Integer, motion_orders: Integer) -> Float:
    """Noise of E_n over that of one head, ``(…, orders)`` for places ``(…, heads)``; inf: not seen.

    At ``motion_orders`` the motion of the axis is unknown as well. At order 1 it cannot be told
    from the disc by any number of heads and is not separated there.
    """
    places = np.asarray(places_rad, dtype=np.float64)
    shape = (*places.shape[:-1], orders.size, places.shape[-1])
    column = np.exp(-1j * np.multiply.outer(orders, places)).transpose(
        *range(1, places.ndim), 0, places.ndim
    )
    one = np.ones(shape, dtype=np.complex128)
    ahead = np.broadcast_to(np.exp(1j * places)[..., None, :], shape)
    moving = np.isin(orders, motion_orders)[:, None]
    # Where nothing moves the two columns are empty.
    others = [one, np.where(moving, ahead, 0.0), np.where(moving, ahead.conj(), 0.0)]
    basis: list[NDArray[np.complex128]] = []
    for other in (*others, column):
        left = other.astype(np.complex128)
        # Twice is enough: classical Gram-Schmidt loses digits in the first round alone.
        for _ in range(2):
            for known in basis:
                left = left - np.sum(known.conj() * left, axis=-1, keepdims=True) * known
        length = np.linalg.norm(left, axis=-1, keepdims=True)
        basis.append(np.where(length > 1e-9, left / np.maximum(length, 1e-9), 0.0))
    remaining = length[..., 0]
    return np.where(remaining > 1.0 / UNSEEN_GAIN, 1.0 / np.maximum(remaining, 1e-12), np.inf)


@dataclass(frozen=True)
class Places:
    """A set of heads with its gains; degrees after head 1."""

    title: str
    places_deg: tuple[float, ...]
    motion: bool
    gain: Float
    """``(orders,)``."""


def best_third(first_deg: Sequence[float], orders: Integer, step_deg: float = 0.5) -> float:
    """Where a further head makes the worst gain of ``orders`` least, degrees after head 1."""
    candidates = np.arange(step_deg, 360.0, step_deg)
    places = np.column_stack([np.tile(first_deg, (candidates.size, 1)), candidates])
    gain = gain_of_places(-np.radians(places), orders, np.zeros(0, dtype=np.int64))
    return float(candidates[np.argmin(gain.max(axis=-1))])


def best_further_two(
    first_deg: Sequence[float], orders: Integer, motion_orders: Integer, step_deg: float = 6.0
) -> tuple[float, float]:
    """Where two further heads make the worst gain least, the axis' motion being unknown too."""
    candidates = np.arange(step_deg, 360.0, step_deg) + 0.5
    third, fourth = (
        grid[np.triu_indices(candidates.size, 1)]
        for grid in np.meshgrid(candidates, candidates, indexing="ij")
    )
    places = np.column_stack([np.tile(first_deg, (third.size, 1)), third, fourth])
    worst = gain_of_places(-np.radians(places), orders, motion_orders).max(axis=-1)
    best = int(np.argmin(worst))
    return float(third[best]), float(fourth[best])
