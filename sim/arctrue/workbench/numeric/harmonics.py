"""Columns that many effects share: cosine and sine of multiples of an angle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Columns = NDArray[np.float64]

BLOCK_ROWS = 1024
"""Rows whose columns stay in the cache of the processor while they are filled one by one."""


def harmonic_columns(angle_rad: NDArray[np.float64], orders: Sequence[float]) -> Columns:
    """cos, sin of every order, in the order cos k₁, sin k₁, cos k₂, …: shape (rows, 2·orders)."""
    columns = np.empty((angle_rad.size, 2 * len(orders)))
    whole = bool(orders) and list(orders) == list(range(1, len(orders) + 1))
    if whole:
        # e^{jkx} by repeated multiplication: two transcendental functions a row in all.
        for start in range(0, angle_rad.size, BLOCK_ROWS):
            block = columns[start : start + BLOCK_ROWS]
            step = np.exp(1j * angle_rad[start : start + BLOCK_ROWS])
            power = np.ones_like(step)
            for index in range(len(orders)):
                power = power * step
                block[:, 2 * index] = power.real
                block[:, 2 * index + 1] = power.imag
        return columns
    for index, order in enumerate(orders):
        phase = order * angle_rad
        np.cos(phase, out=columns[:, 2 * index])
        np.sin(phase, out=columns[:, 2 * index + 1])
    return columns


def disc_difference(
    disc1_rad: NDArray[np.float64], disc2_rad: NDArray[np.float64], orders: Sequence[float]
) -> Columns:
    """What a disc-fixed error of these orders adds to R₂ − R₁: its value at ψ₂ less that at ψ₁."""
    columns = harmonic_columns(disc2_rad, orders)
    columns -= harmonic_columns(disc1_rad, orders)
    return columns


def harmonic_names(orders: Sequence[float], prefix: str = "") -> list[str]:
    """Names of the columns of :func:`harmonic_columns`."""
    return [f"{prefix}{kind} {order:g}" for order in orders for kind in ("cos", "sin")]
