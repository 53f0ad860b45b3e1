"""Converts order, amplitude and counts per turn to the words of a lane."""

from __future__ import annotations

import math
from fractions import Fraction

from arctrue.generated.number_formats import (
    AMPLITUDE_FRACTION,
    AMPLITUDE_WIDTH,
    COUNTS_PER_REV_MAX,
    COUNTS_PER_REV_MIN,
    ORDER_WIDTH,
    PHASE_STEP_WIDTH,
)

ORDER_MAX = (1 << ORDER_WIDTH) - 1
AMPLITUDE_LSB_COUNTS = 1.0 / (1 << AMPLITUDE_FRACTION)
AMPLITUDE_WORD_MAX = (1 << (AMPLITUDE_WIDTH - 1)) - 1
AMPLITUDE_LIMIT_COUNTS = float(1 << (AMPLITUDE_WIDTH - 1 - AMPLITUDE_FRACTION))


def check_counts_per_rev(counts_per_rev: int) -> None:
    """Raise ValueError unless the gateware supports this number of counts per turn."""
    if not COUNTS_PER_REV_MIN <= counts_per_rev <= COUNTS_PER_REV_MAX:
        raise ValueError(
            f"counts_per_rev: {counts_per_rev}, the gateware counts "
            f"{COUNTS_PER_REV_MIN} to {COUNTS_PER_REV_MAX} counts a turn"
        )


def phase_step(order: float, counts_per_rev: int) -> int:
    """Return K = round(n·2⁴⁸ / counts_per_rev) mod 2⁴⁸, in 2⁻⁴⁸ turn per count."""
    exact = Fraction(order) * (1 << (PHASE_STEP_WIDTH + 1))
    rounded = (exact + counts_per_rev) // (2 * counts_per_rev)
    return int(rounded) % (1 << PHASE_STEP_WIDTH)


def turn_step(order: float) -> int:
    """Return ν = round(n·2⁴⁸) mod 2⁴⁸, in 2⁻⁴⁸ turn per turn."""
    return round(Fraction(order) * (1 << PHASE_STEP_WIDTH)) % (1 << PHASE_STEP_WIDTH)


def amplitude_word(name: str, value_counts: float) -> int:
    """Return an amplitude or offset in 2⁻¹¹ count. Raises ValueError for a value that does not
    fit; ``name``: the value, for the message."""
    if not math.isfinite(value_counts):
        raise ValueError(f"{name}: {value_counts} is not a finite number")
    word = round(value_counts / AMPLITUDE_LSB_COUNTS)
    if abs(word) > AMPLITUDE_WORD_MAX:
        raise ValueError(
            f"{name}: {value_counts:g} counts, the gateware holds less than "
            f"{AMPLITUDE_LIMIT_COUNTS:g} counts; is it really an error of the table?"
        )
    return word
