"""Defines the settings of ``arctrue revolution``: a table with the paper's kind of error, its
motion, and the gateware."""

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
"""Range of the error after the correction in section 4 of the paper, measured with a polygon of 24
faces and an autocollimator in ten cycles."""

# An eccentricity of 37.7 µm causes 144″ at a radius of 53.975 mm, and a second order of 6″ shifts
# both ends of the error's range by −6″. The higher orders are typical of a clamped disc; their
# phases are chosen so that the range equals the paper's.
ECCENTRICITY_M = 37.7e-6
ECCENTRICITY_DIRECTION_RAD = 2.1
GRADUATION_ORDERS = (2, 3, 4, 5, 8, 12)
GRADUATION_ARCSEC = (6.0, 1.2, 0.7, 0.5, 0.35, 0.2)
GRADUATION_PHASES_RAD = (4.2, 3.1, 4.1, 4.8, 3.9, 4.6)

PAPER_COUNT_ARCSEC = ARCSEC_PER_TURN / (1 << 24)
_RUN_UP_RAD = float(np.deg2rad(1.0))
# A capture begins at the first sample after both indices. Therefore the motion between the two
# turns is longer than the calculation and the ramp by twice this angle.
_SPARE_RAD = float(np.deg2rad(15.0))
# Assumed number of clocks to read one word of the bank over the bus; 6 were measured.
_CLOCKS_A_READ = 8
DEPTH_STEP = 512
"""Number of samples of which the capture depth is a multiple."""


FOUR_PLACES_DEG = (0.0, 64.3, 177.0, 257.9)
"""Places of four heads relative to head 1, with which any three heads suffice if the fourth fails;
found by ``arctrue alpha --heads 4``."""
FURTHER_OFF_ARCSEC = (-30.0, 40.0)
"""Differences of the true places of heads 3 and 4 from the places that the firmware assumes; they
are within ± 50″."""

LARGEST_RAMP_ARCSEC_S = 1e9
LARGEST_RAMP_ARCSEC_S2 = 1e12
"""Largest rate and largest acceleration of the ramp that the firmware accepts, see
firmware/application/parameters.c.
"""


@dataclass(frozen=True, slots=True)
class RevolutionSettings:
    """Settings of ``arctrue revolution``; the defaults are the paper's conditions."""

    heads: int = 2
    """Number of heads, two or four; with four, the firmware calibrates the mean of their
    readings."""
    lines: int = 16384
    """Number of lines of the disc."""
    interpolation: int = 1024
    """Number of counts per line."""
    lanes: int = LANES_DEFAULT
    """Number of lanes of the gateware."""
    samples: int = 12000
    """Number of samples in a turn."""
    speed_deg_s: float = 30.0
    """Mean speed of the table, degrees a second."""
    clocks_per_count: float = 1.1
    """Number of clocks per count; the simulated clock is slower than the device's clock to reach
    this number."""
    alpha_error_arcsec: float = 50.0
    """Difference of the true separation of the heads from the 33° that the firmware assumes."""
    noise_arcsec: float = 0.2
    """Standard deviation of each head's reading: the paper's repeatability."""
    ripple_rad: float = 0.002
    """Amplitude of the ripple of the angle, radians."""
    ripple_order: int = 7
    """Number of periods of the ripple per turn."""
    orders: int = 32
    """Number of orders that the firmware fits."""
    calculation_s: float = 0.25
    """Duration of a calibration on the Cortex-A9, in the time of the table."""
    limit_arcsec: float = 0.3
    """Permitted error of the corrected output at the paper's size, arcseconds."""
    seed: int = 1
    """Seed of the noise."""

    @property
    def places_deg(self) -> tuple[float, ...]:
        """Return the places of four heads that the firmware assumes; none for two heads at the
        default 33°."""
        return FOUR_PLACES_DEG[: self.heads] if self.heads > 2 else ()

    @property
    def capture_depth(self) -> int:
        """Return the number of samples that a bank holds: the samples of a turn plus a margin,
        rounded up to a multiple of 512."""
        return -(-self.samples * 256 // (250 * DEPTH_STEP)) * DEPTH_STEP

    @property
    def counts_per_rev(self) -> int:
        """Return the number of counts per turn."""
        return self.lines * self.interpolation

    @property
    def arcsec_per_count(self) -> float:
        """Return the size of a count in seconds of arc."""
        return ARCSEC_PER_TURN / self.counts_per_rev

    @property
    def speed_rad_s(self) -> float:
        """Return the mean speed of the table."""
        return float(np.deg2rad(self.speed_deg_s))

    @property
    def clock_hz(self) -> float:
        """Return the number of gateware clocks per second in the time of the table."""
        return clock_hz_for(self.counts_per_rev, self.speed_rad_s, self.clocks_per_count)

    @property
    def sample_period_clocks(self) -> int:
        """Return the number of clocks between two samples."""
        return round(self.counts_per_rev * self.clocks_per_count / self.samples)

    @property
    def poll_clocks(self) -> int:
        """Return the number of clocks between two rounds of the firmware's main loop: the table
        turns by a tenth of a degree in this time."""
        return max(100, round(self.counts_per_rev * self.clocks_per_count / 3600))

    @property
    def ramp_rate(self) -> int:
        """Return the word for the ramp's rate: the register's reset value converted to the time of
        the table."""
        (register,) = [r for r in REGISTERS if r.path == "ramp_rate"]
        preset = register.fields[0].reset or 0
        return min(round(preset * CLOCK_HZ / self.clock_hz), 2**32 - 1)

    @property
    def ramp_acceleration(self) -> int:
        """Return the word for the ramp's acceleration: the reset value in the time of the table.

        Returns 0 (no limit) if the register cannot hold the value, because a smaller value would
        slow the ramp.
        """
        (register,) = [r for r in REGISTERS if r.path == "ramp_acceleration"]
        preset = register.fields[0].reset or 0
        compressed = round(preset * (CLOCK_HZ / self.clock_hz) ** 2)
        return compressed if compressed <= ACCELERATION_MAX else 0

    @property
    def ramp_parameters(self) -> dict[str, float]:
        """Return rate and acceleration in the firmware's units, limited to the ranges that the
        firmware accepts."""
        velocity = ramp_arcsec_s(self.ramp_rate, self.counts_per_rev)
        acceleration = ramp_arcsec_s2(self.ramp_acceleration, self.counts_per_rev)
        return {
            "ramp_arcsec_s": min(velocity, LARGEST_RAMP_ARCSEC_S),
            "ramp_arcsec_s2": min(acceleration, LARGEST_RAMP_ARCSEC_S2),
        }

    def table(self) -> RotaryTable:
        """Return the table with the paper's kind of error.

        Returns
        -------
        RotaryTable
            The table: an eccentric disc with graduation harmonics and noise, read by its heads.
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
            # The noise of each sample is independent of the noise of the other samples.
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
        """Return the motion: from rest over all indices, that of head 1 last, and then the turns.

        Returns
        -------
        Motion
            The motion, at one speed and with a ripple of ``ripple_rad``.
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
        # The ramp travels at most twice the largest error.
        largest_counts = 2 * max(-PAPER_BEFORE_ARCSEC[0], PAPER_BEFORE_ARCSEC[1])
        largest_counts /= self.arcsec_per_count
        rate, acceleration = self.ramp_rate * 2.0**-35, self.ramp_acceleration * 2.0**-59
        gathering = rate / acceleration if acceleration else 0.0
        ramp_s = (largest_counts / rate + gathering) / self.clock_hz
        read_s = self.heads * self.samples * _CLOCKS_A_READ / self.clock_hz
        return (ramp_s + read_s + self.calculation_s) * self.speed_rad_s + 2 * _SPARE_RAD
