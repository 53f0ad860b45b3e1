"""Calculates the table's true angle from the readings alone: θ = R₁ − ε(θ), with ε from the two
heads.

Effects are functions of the true angle; the readings differ from the true angle by up to 150″,
which at order 20 is 0.015 rad of phase. A rough ε suffices: a remaining error of 1″ in ε changes
this phase by 10⁻⁴ rad.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.numeric.harmonics import disc_difference, harmonic_sum
from arctrue.workbench.numeric.symmetric import solve_symmetric

Float = NDArray[np.float64]

ORDERS = tuple(range(1, 21))
LEAST_GAIN = 0.3
"""Orders with a smaller factor |e^{jnα} − 1| are left out of this rough estimate of ε."""
ROUNDS = 2
"""Number of rounds of the iteration. An angle error of 10⁻³ rad changes order n of ε by n·10⁻³ of
its amplitude; after two rounds the relative error is the square of n·10⁻³."""
BLOCK_ROWS = 1 << 16
"""Number of rows of one block; it limits memory only."""
MOST_ROWS = 200_000
"""The rough ε of a longer capture is estimated from evenly spread samples; their number is at least
this value and less than twice this value."""


def true_angle(reading1_rad: Float, difference_rad: Float, head_separation_rad: float) -> Float:
    """Return θ of every sample, radians, unwrapped like ``reading1_rad``.

    ``difference_rad`` is R₂ − R₁ − α. Shapes (rows,).
    """
    orders = [n for n in ORDERS if abs(np.exp(1j * n * head_separation_rad) - 1.0) > LEAST_GAIN]
    step = max(reading1_rad.size // MOST_ROWS, 1)
    few_reading, few_difference = reading1_rad[::step], difference_rad[::step]
    angle = few_reading
    coefficients = np.zeros(2 * len(orders))
    for _ in range(ROUNDS):
        columns = np.hstack(
            [
                disc_difference(angle, angle + head_separation_rad, orders),
                np.ones((angle.size, 1)),
            ]
        )
        solution, _, _, _ = solve_symmetric(columns.T @ columns, columns.T @ few_difference)
        coefficients = solution[:-1]
        angle = few_reading - harmonic_sum(angle, orders, coefficients)
    return _self_consistent(reading1_rad, orders, coefficients)


def _self_consistent(reading_rad: Float, orders: list[int], coefficients: Float) -> Float:
    angle = np.array(reading_rad)
    for start in range(0, angle.size, BLOCK_ROWS):
        part = slice(start, start + BLOCK_ROWS)
        for _ in range(3):
            angle[part] = reading_rad[part] - harmonic_sum(angle[part], orders, coefficients)
    return angle
