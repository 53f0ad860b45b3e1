"""Models the entities ``unit_divider`` and ``slewed_word``, and computes the register words for the
lanes that follow direction or speed."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from arctrue.generated.number_formats import (
    AMPLITUDE_SWEEP_CLOCKS,
    CLOCK_HZ,
    MODULATOR_FRACTION,
)

if TYPE_CHECKING:
    from arctrue.gateware.extension import Conditions

MODULATOR_ONE: Final = 1 << MODULATOR_FRACTION
SLEW_FRACTION: Final = 32


def unit_quotient(dividend: int, divisor: int) -> int:
    """Return dividend / divisor as u1.16, rounded half up and at most 1; return 0 if the divisor is
    0."""
    if divisor == 0:
        return 0
    return min((((dividend << (MODULATOR_FRACTION + 1)) // divisor) + 1) >> 1, MODULATOR_ONE)


def slewed(fine: int, target: int, slew: int) -> int:
    """Return the word ``fine``, s1.32, moved towards ``target``, s1.16, by at most ``slew``,
    u0.32."""
    way = (target << MODULATOR_FRACTION) - fine
    return fine + min(max(way, -slew), slew)


def nominal_speed_word(
    nominal_deg_per_s: float, counts_per_rev: int, clock_hz: float = CLOCK_HZ
) -> int:
    """Return the nominal speed ω₀ as u0.32 counts per clock.

    Raises ValueError for a speed of at least one count per clock, or a speed that rounds to 0.
    """
    word = round(nominal_deg_per_s / 360.0 * counts_per_rev / clock_hz * 2.0**32)
    if not 0 < word < 1 << 32:
        raise ValueError(
            f"nominal_deg_per_s: {nominal_deg_per_s:g} at {counts_per_rev} counts a turn is "
            f"{word / 2.0**32:.3g} counts a clock, expected more than 2^-33 and less than 1"
        )
    return word


def slew_word(seconds: float, clock_hz: float = CLOCK_HZ) -> int:
    """Return the slew per sweep (AMPLITUDE_SWEEP_CLOCKS clocks), u0.32, with which a word changes
    from 0 to 1 in ``seconds``."""
    sweeps = max(seconds * clock_hz / AMPLITUDE_SWEEP_CLOCKS, 1.0)
    return min(math.ceil((1 << SLEW_FRACTION) / sweeps), (1 << SLEW_FRACTION) - 1)


def condition_registers(
    conditions: Conditions, counts_per_rev: int, clock_hz: float = CLOCK_HZ
) -> Mapping[str, int]:
    """Return, by register, the words of the register window ``conditions`` for the conditions of a
    coefficient file."""
    return {
        "conditions.width": conditions.width,
        "conditions.dead_zone": conditions.dead_zone_counts,
        "conditions.nominal_speed": nominal_speed_word(
            conditions.nominal_deg_per_s, counts_per_rev, clock_hz
        ),
    }
