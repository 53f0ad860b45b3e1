"""Simulates a table that is calibrated once from its own heads and then read in further turns."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD, RAD_PER_ARCSEC
from arctrue.calibration.capture_check import WholeTurns
from arctrue.calibration.heads_data import HeadsSettings
from arctrue.calibration.heads_estimate import HeadsEstimate
from arctrue.calibration.heads_gain import MotionOrders
from arctrue.calibration.heads_least_squares import heads_least_squares
from arctrue.calibration.least_squares import least_squares
from arctrue.calibration.mean_banks import mean_angle_counts, mean_banks
from arctrue.gateware.coefficients import Coefficients
from arctrue.studies.revolution import (
    ECCENTRICITY_DIRECTION_RAD,
    ECCENTRICITY_M,
    FOUR_PLACES_DEG,
    GRADUATION_ARCSEC,
    GRADUATION_ORDERS,
    GRADUATION_PHASES_RAD,
)
from arctrue.table import (
    DISC_RADIUS_M,
    Cause,
    DiscEccentricity,
    GraduationHarmonics,
    Motion,
    RotaryTable,
    heads_at,
)

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

COUNTS_PER_REV = 1 << 24
PLACES_DEG = FOUR_PLACES_DEG
TWO_DEG = (0.0, 33.0)
SPEED_RAD_S = float(np.radians(30.0))
MOST_ORDER = 40
MOUNTING_ARCSEC = 50.0
U_MOUNTING_ARCSEC = MOUNTING_ARCSEC / float(np.sqrt(3.0))


@dataclass(frozen=True)
class SelfCalibratedTable:
    """Simulated table with several heads; ``seed`` determines the noise, the radii, and the places
    and index marks of all heads except head 1, within ± 50″ of nominal.
    """

    places_deg: tuple[float, ...] = PLACES_DEG
    noise_arcsec: float = 0.1
    radius_tolerance_m: float = 0.0
    samples_a_turn: int = 12_000
    seed: int = 1
    axis: tuple[Cause, ...] = ()
    """Causes that move the axis while the table is calibrated."""
    mounting_arcsec: float = MOUNTING_ARCSEC
    """Largest deviation of places and index marks from nominal."""
    moved_arcsec: tuple[float, ...] = field(default=())
    """Shift of each head along the scale since the head was mounted."""

    def rotary_table(self, *further: Cause) -> RotaryTable:
        """Return the table with the causes ``further``, which include any motion of the axis."""
        random = np.random.default_rng([self.seed, 11])
        heads = len(self.places_deg)
        off, late = random.uniform(-self.mounting_arcsec, self.mounting_arcsec, (2, heads))
        radii = DISC_RADIUS_M + random.uniform(-1.0, 1.0, heads) * self.radius_tolerance_m
        off[0] = late[0] = 0.0
        moved = np.array(self.moved_arcsec or (0.0,) * heads)
        places = np.radians(self.places_deg) + (off + moved) * RAD_PER_ARCSEC
        count_arcsec = ARCSEC_PER_RAD * 2.0 * np.pi / COUNTS_PER_REV
        disc = (
            DiscEccentricity(ECCENTRICITY_M, ECCENTRICITY_DIRECTION_RAD),
            GraduationHarmonics(
                GRADUATION_ORDERS,
                tuple(a * RAD_PER_ARCSEC for a in GRADUATION_ARCSEC),
                GRADUATION_PHASES_RAD,
            ),
        )
        return RotaryTable(
            heads_at(
                places.tolist(), radii.tolist(), np.rint(late / count_arcsec).astype(int).tolist()
            ),
            (*disc, *further),
            rounding="nearest",
            noise_rad=self.noise_arcsec * RAD_PER_ARCSEC,
        )

    def turn(
        self, number: int, causes: tuple[Cause, ...], turns: int = 1, *, noise: bool = True
    ) -> tuple[Integer, Float]:
        """Return counts (heads, n) and true angles of run ``number``; runs with larger numbers
        start at larger angles."""
        table = self.rotary_table(*causes)
        motion = Motion.steady(
            SPEED_RAD_S,
            turns * 2.0 * np.pi / SPEED_RAD_S + 1.0,
            start_rad=0.3 + number * (14.0 * np.pi + 1.0),
            ripple_rad=0.002,
            ripple_order=7,
        )
        seconds = 2.0 * np.pi / SPEED_RAD_S / self.samples_a_turn
        state = motion.state(np.arange(turns * self.samples_a_turn) * np.float64(seconds))
        random = np.random.default_rng([self.seed, 12, number]) if noise else None
        counts = [table.counts(head, state, random) for head in range(len(table.heads))]
        return np.stack(counts), np.asarray(state.angle_rad)

    def captured(self, number: int = 0, turns: int = 1) -> WholeTurns:
        """Return the counts of one run as a capture of whole turns."""
        counts, _ = self.turn(number, self.axis, turns)
        step = COUNTS_PER_REV / self.samples_a_turn
        return WholeTurns(0, turns, counts[0], counts[1], step, 0, tuple(counts[2:]))

    def estimate(
        self, motion: MotionOrders = "every", turns: int = 1, number: int = 0
    ) -> HeadsEstimate:
        """Estimate the error of the disc from the capture of one run."""
        return heads_least_squares(
            [self.captured(number, turns)],
            COUNTS_PER_REV,
            np.radians(self.places_deg).tolist(),
            HeadsSettings(
                np.arange(1, MOST_ORDER + 1),
                motion,
                U_MOUNTING_ARCSEC,
                U_MOUNTING_ARCSEC,
                self.radius_tolerance_m / float(np.sqrt(3.0)) / DISC_RADIUS_M,
            ),
        )

    def mean(self, motion: MotionOrders = "every") -> Coefficients:
        """Return the gateware's words for the mean of all heads, and a set of words for each head
        that may be missing."""
        coefficients, refused = mean_banks(self.estimate(motion).on_disc(), COUNTS_PER_REV)
        if refused:
            raise refused[0]
        return coefficients


def mean_left_arcsec(coefficients: Coefficients, counts: Integer, angle_rad: Float) -> Float:
    """Return the error that remains in the mean of the heads at the output of the gateware,
    (n,)."""
    return _left(mean_angle_counts(coefficients, counts), angle_rad)


def two_heads_left_arcsec(table: SelfCalibratedTable, counts: Integer, angle_rad: Float) -> Float:
    """Return the error of head 1 that remains after a correction calibrated with the two heads of
    ``table``, (n,)."""
    estimate, _ = least_squares(
        [table.captured()],
        COUNTS_PER_REV,
        float(np.radians(table.places_deg[1])),
        np.arange(1, MOST_ORDER + 1),
        "nominal",
    )
    reading = counts[0] * (2.0 * np.pi / COUNTS_PER_REV)
    corrected = counts[0] - estimate.error_arcsec(reading) * RAD_PER_ARCSEC * (
        COUNTS_PER_REV / (2.0 * np.pi)
    )
    return _left(corrected, angle_rad)


def _left(shown_counts: Float, angle_rad: Float) -> Float:
    left = shown_counts * (2.0 * np.pi / COUNTS_PER_REV) - angle_rad
    return np.asarray(np.angle(np.exp(1j * left)) * ARCSEC_PER_RAD)


def rms(values: Float) -> float:
    """Return the RMS about the mean, because the zero of a table is arbitrary."""
    return float(np.std(values))
