"""Models errors of the sine and cosine signals of a head."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.table.cause import Cause
from arctrue.table.declaration import Declaration, Given, Half, HeadNumber, Occasion, Random, Recipe
from arctrue.table.draws import any_head, vector
from arctrue.table.rotary_table import GRATING_LINES
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class SignalDistortion(Cause):
    """The two signals of one head have offsets, unequal gains, and a phase that differs from 90°.

    The interpolator takes atan2 of the two signals. An offset therefore causes an error with one
    period per signal period; a gain difference or a phase error causes an error with two periods.
    Offsets and gain difference are shares of the signals' amplitude.
    """

    head: int
    lines: int
    cosine_offset: float = 0.0
    sine_offset: float = 0.0
    gain_difference: float = 0.0
    """Difference g of the gains: the cosine has the gain 1 + g/2, the sine 1 − g/2."""
    phase_error_rad: float = 0.0
    """Deviation of the phase between sine and cosine from 90°."""

    def signal_error_rad(
        self, head: int, disc_reading_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64] | float:
        """Return the interpolated place minus the true place within the signal period, as an angle
        of the disc."""
        if head != self.head:
            return 0.0
        phase = np.mod(disc_reading_rad * self.lines, 2 * np.pi)
        cosine = (1 + self.gain_difference / 2) * np.cos(phase) + self.cosine_offset
        sine = (1 - self.gain_difference / 2) * np.sin(phase + self.phase_error_rad)
        sine = sine + self.sine_offset
        seen = np.exp(-1j * phase) * (cosine + 1j * sine)
        return np.asarray(np.angle(seen) / self.lines)


class Values(Given, frozen=True):
    """Values of this cause in a scenario file."""

    head: HeadNumber
    cosine_offset: Half = 0.0
    sine_offset: Half = 0.0
    gain_difference: Half = 0.0
    phase_error_deg: Annotated[float, Meta(ge=-45, le=45)] = 0.0

    def physical(self, lines: int) -> SignalDistortion:
        """Return the cause that these values describe."""
        return SignalDistortion(
            self.head - 1,
            lines,
            self.cosine_offset,
            self.sine_offset,
            self.gain_difference,
            math.radians(self.phase_error_deg),
        )


def draw(size: float, random: Random, occasion: Occasion) -> list[Cause]:
    """Draw a cause of the given ``size``; its unit is that of the ``Recipe`` below."""
    # If the offset is a share p of the amplitude, the error is p radians of the signal period.
    period_rad = size * RAD_PER_ARCSEC * GRATING_LINES
    found: list[Cause] = []
    # With three or four heads only one of them has the fault.
    heads = (0, 1) if len(occasion.heads) == 2 else (any_head(random, occasion),)
    for head in heads:
        offset = vector(period_rad * random.uniform(0.6, 1.0), random)
        second = vector(2 * period_rad * random.uniform(0.2, 0.5), random)
        found.append(
            SignalDistortion(
                head, GRATING_LINES, offset.real, offset.imag, second.real, second.imag
            )
        )
    return found


DECLARATION = Declaration(
    SignalDistortion,
    values=Values,
    recipes=(
        Recipe(
            name="subdivision_error",
            unit="arcsec",
            low=0.06,
            high=2.4,
            draw=draw,
            rank=2,
            coefficients=8,
            coefficients_of_more_heads=4,
        ),
    ),
)
