"""Conditions of one revolution: the table with the paper's kind of error, and its motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from arctrue.base.units import ARCSEC_PER_TURN, RAD_PER_ARCSEC
from arctrue.gateware.correction_ramp import ACCELERATION_MAX, ramp_arcsec_s, ramp_arcsec_s2
from arctrue.generated.number_formats import CLOCK_HZ, LANES_DEFAULT
from arctrue.generated.registers import REGISTERS
from arctrue.instrument.instrument import clock_hz_for
from arctrue.instrument.noise import ReadingNoise
from arctrue.table import (
    HEAD_SEPARATION_RAD,
    DiscEccentricity,
    GraduationHarmonics,
    Motion,
    RotaryTable,
    heads_at,
    two_heads,
)

TURN_RAD = 2 * np.pi

PAPER_BEFORE_ARCSEC = (-150.0, 137.9)
PAPER_AFTER_ARCSEC = (-1.3, 1.6)
"""Range of error after the correction, section 4 of the paper: a polygon of 24 faces and an
autocollimator, ten cycles."""

# An eccentricity of 37.7 µm is 144″ at a radius of 53.975 mm, and a second order of 6″ shifts both
# ends of the paper's range by −6″. The orders above it are those of a clamped disc, with phases
# that give the ends of the paper's range.
ECCENTRICITY_M = 37.7e-6
ECCENTRICITY_DIRECTION_RAD = 2.1
GRADUATION_ORDERS = (2, 3, 4, 5, 8, 12)
GRADUATION_ARCSEC = (6.0, 1.2, 0.7, 0.5, 0.35, 0.2)
GRADUATION_PHASES_RAD = (4.2, 3.1, 4.1, 4.8, 3.9, 4.6)

PAPER_COUNT_ARCSEC = ARCSEC_PER_TURN / (1 << 24)
_RUN_UP_RAD = float(np.deg2rad(1.0))
# A capture begins at the first sample after both indices; the calculation and the ramp follow.
_SPARE_RAD = float(np.deg2rad(15.0))
# Clocks for one word of the bank over the bus; measured: 6.
_CLOCKS_A_READ = 8
DEPTH_STEP = 512
"""Half a degree: 23,302 edges at 2²⁴, in which noise averages out and slow errors do not."""


FOUR_PLACES_DEG = (0.0, 64.3, 177.0, 257.9)
"""Places of four heads after head 1; any one head may fail: ``arctrue alpha --heads 4``."""
FURTHER_OFF_ARCSEC = (-30.0, 40.0)
"""Distances of heads 3 and 4 from the places that the firmware assumes, within ± 50″."""

LARGEST_RAMP_ARCSEC_S = 1e9
LARGEST_RAMP_ARCSEC_S2 = 1e12
"""Largest value that the firmware's parameters accept: firmware/application/parameters.c."""


@dataclass(frozen=True, slots=True)
class RevolutionSettings:
    """The paper's conditions; tests use smaller ones."""

    heads: int = 2
    """Number of heads: two, or four whose mean the firmware calibrates."""
    lines: int = 16384
    """Lines of the disc."""
    interpolation: int = 1024
    """Counts per line."""
    lanes: int = LANES_DEFAULT
    """Lanes of the gateware."""
    samples: int = 12000
    """Samples in a turn."""
    speed_deg_s: float = 30.0
    """Mean speed of the table, degrees a second."""
    clocks_per_count: float = 1.1
    """Clocks per count; the clock of the gateware is reduced to reach it."""
    alpha_error_arcsec: float = 50.0
    """Difference of the heads' separation from the 33° that the firmware assumes."""
    noise_arcsec: float = 0.2
    """Standard deviation of each head's reading: the paper's repeatability."""
    ripple_rad: float = 0.002
    """Amplitude of the ripple of the angle, radians."""
    ripple_order: int = 7
    """Periods of the ripple a turn."""
    orders: int = 32
    """Orders that the firmware fits."""
    calculation_s: float = 0.25
    """Duration of a calibration on the Cortex-A9, in table time."""
    limit_arcsec: float = 0.3
    """Permitted error of the corrected output at the paper's size, arcseconds."""
    seed: int = 1
    """Seed of the noise."""

    @property
    def places_deg(self) -> tuple[float, ...]:
        """Places of four heads that the firmware assumes; for two it knows 33°."""
        return FOUR_PLACES_DEG[: self.heads] if self.heads > 2 else ()

    @property
    def capture_depth(self) -> int:
        """Samples that a bank holds: those of a turn plus a margin, in steps of 512."""
        return -(-self.samples * 256 // (250 * DEPTH_STEP)) * DEPTH_STEP

    @property
    def counts_per_rev(self) -> int:
        """Counts per turn."""
        return self.lines * self.interpolation

    @property
    def arcsec_per_count(self) -> float:
        """One count in seconds of arc."""
        return ARCSEC_PER_TURN / self.counts_per_rev

    @property
    def speed_rad_s(self) -> float:
        """Mean speed of the table."""
        return float(np.deg2rad(self.speed_deg_s))

    @property
    def clock_hz(self) -> float:
        """Clocks of the gateware per second of table time."""
        return clock_hz_for(self.counts_per_rev, self.speed_rad_s, self.clocks_per_count)

    @property
    def sample_period_clocks(self) -> int:
        """Clocks between two samples."""
        return round(self.counts_per_rev * self.clocks_per_count / self.samples)

    @property
    def poll_clocks(self) -> int:
        """Clocks between two rounds of the firmware's main loop: a tenth of a degree."""
        return max(100, round(self.counts_per_rev * self.clocks_per_count / 3600))

    @property
    def ramp_rate(self) -> int:
        """Reset value of the register in counts per second of table time."""
        (register,) = [r for r in REGISTERS if r.path == "ramp_rate"]
        preset = register.fields[0].reset or 0
        return min(round(preset * CLOCK_HZ / self.clock_hz), 2**32 - 1)

    @property
    def ramp_acceleration(self) -> int:
        """Reset value for the ramp's acceleration: compressed time compresses its seconds too.

        0 (no limit) if the register cannot hold the value: a smaller one would slow the ramp.
        """
        (register,) = [r for r in REGISTERS if r.path == "ramp_acceleration"]
        preset = register.fields[0].reset or 0
        compressed = round(preset * (CLOCK_HZ / self.clock_hz) ** 2)
        return compressed if compressed <= ACCELERATION_MAX else 0

    @property
    def ramp_parameters(self) -> dict[str, float]:
        """Return rate and acceleration as the firmware has them, limited to its ranges."""
        velocity = ramp_arcsec_s(self.ramp_rate, self.counts_per_rev)
        acceleration = ramp_arcsec_s2(self.ramp_acceleration, self.counts_per_rev)
        return {
            "ramp_arcsec_s": min(velocity, LARGEST_RAMP_ARCSEC_S),
            "ramp_arcsec_s2": min(acceleration, LARGEST_RAMP_ARCSEC_S2),
        }

    def table(self) -> RotaryTable:
        """Make the table with the paper's kind of error.

        Returns
        -------
        RotaryTable
            An eccentric disc with graduation harmonics and noise, read by two heads.
        """
        effects: list[Any] = [
            DiscEccentricity(ECCENTRICITY_M, ECCENTRICITY_DIRECTION_RAD),
            GraduationHarmonics(
                GRADUATION_ORDERS,
                tuple(arcsec * RAD_PER_ARCSEC for arcsec in GRADUATION_ARCSEC),
                GRADUATION_PHASES_RAD,
            ),
        ]
        if self.noise_arcsec:
            # The noise is independent from one sample to the next.
            correlation_s = self.sample_period_clocks / self.clock_hz / 5
            effects.append(
                ReadingNoise(self.noise_arcsec * RAD_PER_ARCSEC, correlation_s, self.seed)
            )
        separation = HEAD_SEPARATION_RAD + self.alpha_error_arcsec * RAD_PER_ARCSEC
        off = np.array((0.0, self.alpha_error_arcsec, *FURTHER_OFF_ARCSEC)) * RAD_PER_ARCSEC
        places = np.radians(self.places_deg) + off[: len(self.places_deg)]
        return RotaryTable(
            heads=two_heads(separation_rad=separation)
            if self.heads == 2
            else heads_at(places.tolist()),
            causes=tuple(effects),
            counts_per_rev=self.counts_per_rev,
        )

    def motion(self) -> Motion:
        """Make the motion: from rest over all indices, head 1's last, and two and a half turns.

        Returns
        -------
        Motion
            At one speed, with a ripple of ``ripple_rad``.
        """
        before_rad = float(np.radians(max(self.places_deg, default=0.0))) or HEAD_SEPARATION_RAD
        start = -before_rad - 2 * _RUN_UP_RAD
        travel = -start + 2 * TURN_RAD + self._between_turns_rad()
        ramp_s = 2 * _RUN_UP_RAD / self.speed_rad_s
        return Motion.steady(
            self.speed_rad_s,
            travel / self.speed_rad_s + 2 * ramp_s,
            ramp_s=ramp_s,
            start_rad=start,
            ripple_rad=self.ripple_rad,
            ripple_order=self.ripple_order,
        )

    def _between_turns_rad(self) -> float:
        # The ramp removes at most twice the largest error.
        largest_counts = 2 * max(-PAPER_BEFORE_ARCSEC[0], PAPER_BEFORE_ARCSEC[1])
        largest_counts /= self.arcsec_per_count
        rate, acceleration = self.ramp_rate * 2.0**-35, self.ramp_acceleration * 2.0**-59
        gathering = rate / acceleration if acceleration else 0.0
        ramp_s = (largest_counts / rate + gathering) / self.clock_hz
        read_s = self.heads * self.samples * _CLOCKS_A_READ / self.clock_hz
        return (ramp_s + read_s + self.calculation_s) * self.speed_rad_s + 2 * _SPARE_RAD
