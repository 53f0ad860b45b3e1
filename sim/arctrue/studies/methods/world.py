"""Simulates the table that every method measures; disc, bearing, noise and measuring time are the
same for all methods."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD, RAD_PER_ARCSEC
from arctrue.instrument.turn_score import TurnScore
from arctrue.studies.paper.published import PUBLISHED
from arctrue.studies.revolution import (
    ECCENTRICITY_DIRECTION_RAD,
    ECCENTRICITY_M,
    GRADUATION_ARCSEC,
    GRADUATION_ORDERS,
    GRADUATION_PHASES_RAD,
)
from arctrue.table import (
    DISC_RADIUS_M,
    Cause,
    DiscEccentricity,
    GraduationHarmonics,
    Head,
    Motion,
    RotaryTable,
    TableState,
)
from arctrue.table.causes.ball_pass import BallPass
from arctrue.table.causes.radial_motion import RadialMotion
from arctrue.table.instruments import Autocollimator, Polygon

Float = NDArray[np.float64]
Counts = NDArray[np.int64]
Correction = Callable[[Float], Float]
"""Function that returns head 1's error in arcseconds from its reading in radians, any shape."""


@dataclass(frozen=True)
class Output:
    """Output of a calibrated table: a function that computes the angle from the readings of
    heads."""

    places_rad: tuple[float, ...]
    """Stator angles of the heads that are read, head 1 first."""
    angle: Callable[[Float], Float]
    """Function that returns the angle in radians, (n,), from readings in radians, (heads, n); its
    zero is arbitrary."""

    @classmethod
    def of_head1(cls, correction: Correction) -> Output:
        """Return an output that subtracts ``correction`` from the reading of head 1."""
        return cls((0.0,), lambda reading: reading[0] - correction(reading[0]) * RAD_PER_ARCSEC)


TURN_RAD = 2.0 * np.pi
SCORED_ANGLES = 7200
"""Number of evaluated angles, every twentieth of a degree: 60 per period of order 120."""
MOST_SCORED_ORDER = 128
LATER_TURNS = 3
MOUNTING_ARCSEC = 50.0
"""Tolerance of a head's place, as in the paper."""

WEAK_ORDER = 11
"""Order that two heads at α = 33° determine with 19 times the noise of their difference."""
SYMMETRIC_ORDERS = (12, 24)
"""Orders that 4 or 12 equally spaced heads cannot determine; 24 faces cannot determine order 24
either."""
BLIND_ORDER = 120
"""Order that two heads 33° apart cannot determine."""
UNLISTED_ARCSEC = {47: 0.05, 77: 0.03}
"""Amplitudes of further orders of the disc, by order; no method fits these orders."""
UNLISTED_MOTION = {1: -0.3, 9: 0.3, 13: -0.2}
"""Further circles of the axis by order, relative to the circle of order 2; those with a negative
size turn backwards. Only methods that allow motion at every order allow it at orders 9 and 13."""
BALLS_M, BALLS_ORDER = 0.25e-6, 4.37
HUB_SHIFT_M = 2e-6
"""Shift of the disc on its hub. After the calibration, this shift and the ball pass of the bearing
are added."""


@dataclass(frozen=True)
class MethodsSettings:
    """Conditions of the measurement, the same for all methods."""

    minutes: float = 16.0
    """Measuring time: ten cycles of 24 faces of 4 s each, as in the paper; or 80 turns at 30°/s."""
    station_s: float = 4.0
    speed_deg_s: float = 30.0
    sampling_hz: float = 1000.0
    noise_arcsec: float = 0.1
    """Standard deviation of a head's reading."""
    scatter_arcsec: float = 0.08
    """Standard deviation of a reading of the autocollimator, the same as in ``arctrue paper``."""
    radial_motion_m: float = 0.1e-6
    """Amplitude of the axis' motion at order 2; at order 3 the amplitude is half as large."""
    ripple_rad: float = 0.002
    ripple_order: int = 7
    most_order: int = 40
    counts_per_rev: int = 1 << 24
    seed: int = 1
    index_detection_arcsec: float = 0.0
    """Largest error of the place at which a head detects the index mark."""
    radius_tolerance_m: float = 0.0
    """Largest difference of a head's radius from the disc's radius."""
    unlisted: bool = False
    """Whether disc and axis also have orders that no method fits."""

    @classmethod
    def compared(cls, minutes: float = 16.0, seed: int = 1) -> MethodsSettings:
        """Return the settings of ``arctrue methods``: index marks known to ± 50″, radii to ± 0.1
        mm, and orders that no method fits."""
        return cls(
            minutes=minutes,
            seed=seed,
            index_detection_arcsec=MOUNTING_ARCSEC,
            radius_tolerance_m=1e-4,
            unlisted=True,
        )

    @property
    def time_s(self) -> float:
        """Return the measuring time of every method in seconds; pauses between the parts of a
        measurement do not count."""
        return 60.0 * self.minutes

    @property
    def turns(self) -> int:
        """Return the number of whole turns in a capture."""
        return int(self.time_s * self.speed_deg_s / 360.0)

    @property
    def cycles(self) -> int:
        """Return the number of whole cycles over the polygon."""
        return int(self.time_s / (self.station_s * PUBLISHED.faces))

    @property
    def samples_a_turn(self) -> int:
        """Return the number of samples in a turn."""
        return round(360.0 / self.speed_deg_s * self.sampling_hz)

    @property
    def orders(self) -> NDArray[np.int64]:
        """Return the orders that every method fits if the method can determine them: 1 to
        ``most_order``, and BLIND_ORDER."""
        return np.append(np.arange(1, self.most_order + 1), BLIND_ORDER)


@dataclass(frozen=True)
class World:
    """Simulated table with all its measurements."""

    settings: MethodsSettings

    @cached_property
    def effects(self) -> tuple[Cause, ...]:
        """Return the disc of ``arctrue revolution`` with four more orders, and a moving bearing."""
        extra = (WEAK_ORDER, *SYMMETRIC_ORDERS, BLIND_ORDER)
        orders = (*(o for o in GRADUATION_ORDERS if o not in extra), *extra)
        known = dict(zip(GRADUATION_ORDERS, GRADUATION_ARCSEC, strict=True))
        phases = dict(zip(GRADUATION_ORDERS, GRADUATION_PHASES_RAD, strict=True))
        further = {11: 0.4, 12: 0.2, 24: 0.3, 120: 0.2}
        size = self.settings.radial_motion_m
        unlisted: tuple[Cause, ...] = ()
        if self.settings.unlisted:
            orders = (*orders, *UNLISTED_ARCSEC)
            further |= UNLISTED_ARCSEC
            unlisted = tuple(
                RadialMotion(
                    order, part * size if part > 0 else 0j, 0j if part > 0 else -part * size
                )
                for order, part in UNLISTED_MOTION.items()
            )
        return (
            DiscEccentricity(ECCENTRICITY_M, ECCENTRICITY_DIRECTION_RAD),
            GraduationHarmonics(
                orders,
                tuple(further.get(o, known.get(o, 0.0)) * RAD_PER_ARCSEC for o in orders),
                tuple(phases.get(o, 0.7 * o) for o in orders),
            ),
            RadialMotion.along(2, size, 0.6, 1.0),
            RadialMotion(3, 0.5 * size * np.exp(0.4j)),
            *unlisted,
        )

    @cached_property
    def later(self) -> tuple[Cause, ...]:
        """Return the causes that are added to the table after the calibration: ball pass and a
        shift of the hub."""
        return (BallPass(BALLS_ORDER, BALLS_M), DiscEccentricity(HUB_SHIFT_M, 0.8))

    def table(
        self, places_rad: Sequence[float] = (0.0,), further: tuple[Cause, ...] = ()
    ) -> RotaryTable:
        """Return the table with heads up to 50″ from their nominal places; head 1 is at angle 0.

        The index marks repeat to ± 1 count. All methods with a head at one place get the same head
        at this place. ``further``: causes in addition to the causes of the calibrated table.
        """
        heads = []
        for place in places_rad:
            own = np.random.default_rng(
                [self.settings.seed, round(np.degrees(place % TURN_RAD) * 1e3)]
            )
            off = own.uniform(-MOUNTING_ARCSEC, MOUNTING_ARCSEC) * RAD_PER_ARCSEC
            index = int(own.integers(-1, 2))
            late = own.uniform(-1.0, 1.0) * self.settings.index_detection_arcsec * RAD_PER_ARCSEC
            index += round(late / self.count_rad)
            radius = DISC_RADIUS_M + own.uniform(-1.0, 1.0) * self.settings.radius_tolerance_m
            first = place == 0.0
            heads.append(
                Head.on_circle(radius, 0.0 if first else place + off, 0 if first else index)
            )
        return RotaryTable(
            heads=tuple(heads),
            causes=(*self.effects, *further),
            counts_per_rev=self.settings.counts_per_rev,
            noise_rad=self.settings.noise_arcsec * RAD_PER_ARCSEC,
        )

    @property
    def count_rad(self) -> float:
        """Return the size of a count in radians."""
        return TURN_RAD / self.settings.counts_per_rev

    def turns(self, places_rad: Sequence[float]) -> Iterator[Counts]:
        """Yield, for each turn, the counts of all heads, ``(heads, samples)``, latched at the same
        instants."""
        given = self.settings
        table = self.table(places_rad)
        random = np.random.default_rng([given.seed, len(places_rad)])
        duration_s = given.turns * given.samples_a_turn / given.sampling_hz
        motion = Motion.steady(
            float(np.radians(given.speed_deg_s)),
            duration_s,
            ripple_rad=given.ripple_rad,
            ripple_order=given.ripple_order,
        )
        for turn in range(given.turns):
            sample = np.arange(given.samples_a_turn) + turn * given.samples_a_turn
            state = motion.state(sample / given.sampling_hz)
            yield np.stack([table.counts(head, state, random) for head in range(len(places_rad))])

    def reading_at_rest_rad(self, angle_rad: Float) -> Float:
        """Return the reading of head 1 at rest at each angle, as a mean without noise and
        rounding."""
        return self.table().reading_rad(0, TableState.at_rest(angle_rad))

    def instruments(self) -> tuple[Polygon, Autocollimator]:
        """Return the polygon and the autocollimator of the paper's Table 3."""
        random = np.random.default_rng([self.settings.seed, 24])
        return (
            PUBLISHED.drawn_polygon(random),
            PUBLISHED.drawn_autocollimator(self.settings.scatter_arcsec, random),
        )

    def stations(self, shifts: Sequence[int]) -> tuple[Float, Float, NDArray[np.int64]]:
        """Read the polygon in every cycle: reading of head 1, and error that the polygon measures.

        In cycle i the polygon is mounted rotated by ``shifts[i]`` faces. At each of 24 angles the
        *reading* of head 1 is moved to the target, and the table stands for ``station_s``; the
        readings of both instruments are averaged. Returns readings in radians ``(faces,)``, errors
        in arcseconds ``(cycles, faces)`` and the number of the visible face ``(cycles, faces)``.
        """
        polygon, autocollimator = self.instruments()
        random = np.random.default_rng([self.settings.seed, 25])
        faces = polygon.faces
        target: Float = np.arange(faces) * np.float64(TURN_RAD / faces)
        stands = target.copy()
        for _ in range(6):
            stands += target - self.reading_at_rest_rad(stands)
        place = np.arange(faces, dtype=np.intp)
        errors, seen = [], []
        for shift in shifts:
            face = (place - shift) % faces
            direction = polygon.direction_rad(face, stands - target)
            # The autocollimator's error depends on the position in its field, and therefore on the
            # station.
            reading = autocollimator.reading_rad(place, direction, random)
            errors.append(-reading * ARCSEC_PER_RAD)
            seen.append(face)
        return target, np.array(errors), np.array(seen, dtype=np.int64)

    def score(self, output: Output | None, *, later: bool = False) -> TurnScore:
        """Compare ``output`` (None: head 1 without correction) with the true angle, mean removed.

        The table is at rest at each angle, and the readings of the heads are averaged until noise
        and rounding vanish. With ``later``, the comparison takes place some turns later, with the
        causes that are added after the calibration.
        """
        if output is None:
            output = Output.of_head1(np.zeros_like)
        middle = np.arange(SCORED_ANGLES) + 0.5
        angle: Float = middle * np.float64(TURN_RAD / SCORED_ANGLES)
        table = self.table(output.places_rad, self.later if later else ())
        state = TableState.at_rest(angle + (LATER_TURNS * TURN_RAD if later else 0.0))
        reading = np.stack([table.reading_rad(h, state) for h in range(len(table.heads))])
        error = output.angle(reading) - state.angle_rad
        wrapped = np.angle(np.exp(1j * (error - error[0]))) * ARCSEC_PER_RAD
        return TurnScore.of_even_readings(wrapped, MOST_SCORED_ORDER)
