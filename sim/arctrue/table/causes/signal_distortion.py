"""The sine and cosine signals of a head are not perfect."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.causes.base import PhysicalEffect
from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class SignalDistortion(PhysicalEffect):
    """Offsets, unequal gains and a wrong phase of the two signals of one head.

    The interpolator takes atan2 of what it gets, so an offset returns once a signal period and
    gain or phase twice. Offsets and gain difference are shares of the signals' amplitude.
    """

    head: int
    lines: int
    cosine_offset: float = 0.0
    sine_offset: float = 0.0
    gain_difference: float = 0.0
    """Cosine (1 + g/2), sine (1 − g/2)."""
    phase_error_rad: float = 0.0
    """How far the sine is from 90° to the cosine."""

    def signal_error_rad(
        self, head: int, disc_reading_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64] | float:
        """Interpolated less true place within the signal period, as an angle of the disc."""
        if head != self.head:
            return 0.0
        phase = np.mod(disc_reading_rad * self.lines, 2 * np.pi)
        cosine = (1 + self.gain_difference / 2) * np.cos(phase) + self.cosine_offset
        sine = (1 - self.gain_difference / 2) * np.sin(phase + self.phase_error_rad)
        sine = sine + self.sine_offset
        seen = np.exp(-1j * phase) * (cosine + 1j * sine)
        return np.asarray(np.angle(seen) / self.lines)
