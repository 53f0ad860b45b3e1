"""Models the entity ``cordic_rotation``: equations (10) to (12), of which only the cosine is
computed."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.generated.number_formats import (
    CORDIC_ITERATIONS,
    COSINE_WIDTH,
    GUARD_WIDTH,
    PHASE_WIDTH,
    TABULATED_ITERATIONS,
    Y_SAVED_WIDTH,
)

COSINE_WIDTHS = range(8, 25)
ITERATIONS = range(8, 25)


@dataclass(frozen=True, eq=False)
class RotationTables:
    """Constants that are computed when the entity is elaborated.

    ``steps``: arctan 2⁻ⁱ in 2⁻ᶠ turn, f = ``angle_fraction``; ``x`` and ``y``: int32 (64,), after
    the tabulated iterations, in units of their last bits; ``y_final``: the first iteration that
    does not change y.
    """

    angle_fraction: int
    steps: tuple[int, ...]
    x: NDArray[np.int32]
    y: NDArray[np.int32]
    y_final: int


def start_radius(iterations: int = CORDIC_ITERATIONS) -> float:
    """Return x₀ of equation (11), which is the inverse of the gain of all iterations."""
    return 1.0 / math.prod(math.sqrt(1.0 + 2.0 ** (-2 * i)) for i in range(iterations))


@functools.cache
def rotation_tables(cosine_width: int, iterations: int) -> RotationTables:
    """Compute the constants for ``cosine_width`` bits. Raises ValueError for a width or a number of
    iterations that the entity does not support."""
    if cosine_width not in COSINE_WIDTHS or iterations not in ITERATIONS:
        raise ValueError(
            f"cosine of {cosine_width} bits with {iterations} iterations: the gateware has "
            f"{COSINE_WIDTHS[0]} to {COSINE_WIDTHS[-1]} bits, {ITERATIONS[0]} to {ITERATIONS[-1]} "
            "iterations"
        )
    fraction = cosine_width - 2 + GUARD_WIDTH
    angle_fraction = min(cosine_width + 3, PHASE_WIDTH)
    steps = tuple(
        math.floor(math.atan(2.0**-i) / (2.0 * math.pi) * 2.0**angle_fraction + 0.5)
        for i in range(iterations)
    )
    x = y = np.full(1, start_radius(iterations))
    for i in range(1, TABULATED_ITERATIONS):
        # Replace every vector by two: one rotated to the left and one rotated to the right.
        direction = np.tile([1.0, -1.0], x.size)
        x, y = np.repeat(x, 2), np.repeat(y, 2)
        x, y = x - direction * y * 2.0**-i, y + direction * x * 2.0**-i
    return RotationTables(
        angle_fraction,
        steps,
        np.floor(x * 2.0**fraction + 0.5).astype(np.int32),
        np.floor(y * 2.0 ** (fraction - Y_SAVED_WIDTH) + 0.5).astype(np.int32),
        (fraction + 3) // 2,
    )


def cordic_rotation(
    folded: NDArray[np.int32],
    cosine_width: int = COSINE_WIDTH,
    iterations: int = CORDIC_ITERATIONS,
) -> NDArray[np.int32]:
    """Return x after the last iteration in 2⁻ᶠ, f = ``cosine_width``.

    x has two bits more than the cosine. ``folded``: int32, 2⁻²⁴ turn, below a quarter turn, of any
    shape; the result has the same shape.
    """
    tables = rotation_tables(cosine_width, iterations)
    z = folded >> (PHASE_WIDTH - tables.angle_fraction)
    z -= tables.steps[0]
    right = np.empty_like(z)
    change = np.empty_like(z)
    index = np.zeros_like(z)
    for i in range(1, TABULATED_ITERATIONS):
        # −1 if the rotation goes to the right, else 0.
        np.right_shift(z, 31, out=right)
        index += index
        index -= right
        # The change is the step; in a rotation to the right it is −step, the complement plus 1.
        np.bitwise_xor(right, tables.steps[i], out=change)
        change -= right
        z -= change
    x = tables.x.take(index)
    y = tables.y.take(index)
    del index
    x_change = np.empty_like(z)
    for i in range(TABULATED_ITERATIONS, iterations):
        np.right_shift(z, 31, out=right)
        if i < tables.y_final:
            # The added half unit makes the truncation of the lower bits round the value.
            shift = i + Y_SAVED_WIDTH
            np.add(x, 1 << (shift - 1), out=x_change)
            x_change >>= shift
            x_change ^= right
            x_change -= right
        shift = i - Y_SAVED_WIDTH
        np.add(y, 1 << (shift - 1), out=change)
        change >>= shift
        change ^= right
        change -= right
        x -= change
        if i < tables.y_final:
            y += x_change
        if i < iterations - 1:
            np.bitwise_xor(right, tables.steps[i], out=change)
            change -= right
            z -= change
    return x
