"""Computes columns that many effects share: cosine and sine of multiples of an angle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Columns = NDArray[np.float64]

BLOCK_ROWS = 1024
"""Rows in a block of harmonic_columns; all columns of a block fit into the processor's cache."""
SUMMED_ROWS = 1 << 13
"""Rows in a block of harmonic_sum; the sum over the orders fits into the processor's cache."""


def harmonic_columns(angle_rad: NDArray[np.float64], orders: Sequence[float]) -> Columns:
    """Return cos and sin of every order k of the angle x: cos k₁x, sin k₁x, cos k₂x, …; shape
    (rows, 2·orders)."""
    columns = np.empty((angle_rad.size, 2 * len(orders)))
    wanted = [round(order) for order in orders]
    rising = wanted == list(orders) and wanted == sorted(set(wanted)) and min(wanted, default=0) > 0
    if rising and wanted[-1] <= 2 * len(wanted):
        # Repeated multiplication of e^{jx} needs only two transcendental functions per row.
        places = {order: index for index, order in enumerate(wanted)}
        waves = columns.view(np.complex128)  # a cosine and its sine are one complex number
        for start in range(0, angle_rad.size, BLOCK_ROWS):
            block = waves[start : start + BLOCK_ROWS]
            step = np.exp(1j * angle_rad[start : start + BLOCK_ROWS])
            power, following = np.ones_like(step), np.empty_like(step)
            for whole in range(1, wanted[-1] + 1):
                np.multiply(power, step, out=following)
                power, following = following, power
                if whole in places:
                    block[:, places[whole]] = power
        return columns
    for index, order in enumerate(orders):
        phase = order * angle_rad
        np.cos(phase, out=columns[:, 2 * index])
        np.sin(phase, out=columns[:, 2 * index + 1])
    return columns


def harmonic_sum(
    angle_rad: NDArray[np.float64], orders: Sequence[int], coefficients: Columns
) -> NDArray[np.float64]:
    """Return :func:`harmonic_columns` times coefficients, (rows,), without storing the columns.

    ``orders`` are whole and positive. The sum is Re Σ (a − jb)·zᵏ with z = e^{jx}, by Horner's
    scheme.
    """
    weights = np.zeros(max(orders, default=0) + 1, dtype=np.complex128)
    weights[list(orders)] = coefficients[0::2] - 1j * coefficients[1::2]
    found = np.zeros(angle_rad.size)
    for start in range(0, angle_rad.size, SUMMED_ROWS):
        block = slice(start, start + SUMMED_ROWS)
        step = np.empty(angle_rad[block].size, dtype=np.complex128)
        np.cos(angle_rad[block], out=step.real)
        np.sin(angle_rad[block], out=step.imag)
        total = np.full_like(step, weights[-1])
        for weight in weights[-2::-1]:
            total *= step
            total += weight
        found[block] = total.real
    return found


def disc_difference(
    disc1_rad: NDArray[np.float64], disc2_rad: NDArray[np.float64], orders: Sequence[float]
) -> Columns:
    """Return the columns that a disc-fixed error of these orders has in R₂ − R₁: its value at
    ``disc2_rad`` minus its value at ``disc1_rad``."""
    columns = harmonic_columns(disc2_rad, orders)
    columns -= harmonic_columns(disc1_rad, orders)
    return columns


def harmonic_names(orders: Sequence[float], prefix: str = "") -> list[str]:
    """Return the names of the columns of :func:`harmonic_columns`."""
    return [f"{prefix}{kind} {order:g}" for order in orders for kind in ("cos", "sin")]
