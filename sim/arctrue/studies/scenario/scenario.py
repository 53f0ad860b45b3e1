"""Defines a scenario as plain values, and makes its table and motion."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Annotated, Literal, get_args

import numpy as np
from msgspec import Meta, Struct, structs

from arctrue.base.typed_content import NotNegative, Number
from arctrue.base.units import ARCSEC_PER_TURN, RAD_PER_ARCSEC
from arctrue.gateware.coefficients import Coefficients
from arctrue.instrument import clock_hz_for
from arctrue.instrument.noise import ReadingNoise
from arctrue.studies.revolution import DEPTH_STEP, RevolutionSettings
from arctrue.studies.scenario.course import Course, Leg
from arctrue.table import (
    HEAD_SEPARATION_RAD,
    Cause,
    DiscEccentricity,
    GraduationHarmonics,
    RotaryTable,
    two_heads,
)
from arctrue.table.instruments.polygon import FACES
from arctrue.table.temperature import TemperatureCourse

EDGES_KEPT_A_TURN = 1 << 16
EDGES_KEPT = 1 << 22
"""Largest number of edges that a recording of the whole motion keeps per signal: 100 MB."""


MOST_COUNTS_PER_REV = 1 << 24

Flag = Literal[
    "head1.index_error",
    "head1.illegal",
    "head1.overspeed",
    "head2.index_error",
    "head2.illegal",
    "head2.overspeed",
    "status.cannot_keep_up",
]
Reason = Literal[
    "empty",
    "index_not_seen",
    "index_error",
    "illegal_transition",
    "edge_spacing",
    "bank_full",
    "stands_still",
    "short_of_a_turn",
    "more_than_a_turn",
    "reversal",
    "jump",
    "wrong_step",
    "over_speed",
    "inconsistent_heads",
    "heads_exchanged",
    "heads_elsewhere",
    "singular",
    "not_converged",
    "not_finite",
    "amplitude",
    "no_mean",
    "noise",
    "not_better",
]
"""Reasons for which the firmware refuses a capture or keeps the coefficients, with the names that
its telemetry uses."""
FLAGS: tuple[str, ...] = get_args(Flag)
REASONS: tuple[str, ...] = get_args(Reason)


class Scale(Struct, frozen=True, forbid_unknown_fields=True):
    """Size of disc, gateware and capture; it is the key ``[scale]`` of the file."""

    lines: Annotated[int, Meta(ge=16, le=16384)] = 1024
    interpolation: Annotated[int, Meta(ge=4, le=1024)] = 1024
    lanes: Annotated[int, Meta(ge=1, le=64)] = 4
    samples: Annotated[int, Meta(ge=400, le=12000)] = 1200
    """Number of samples in a turn at the slowest speed; a faster turn has fewer."""
    clocks_per_count: Annotated[float, Meta(ge=1.05, le=100)] = 1.1
    """Number of clocks per count at the fastest speed."""
    seed: Annotated[int, Meta(ge=0, le=2**31)] = 1
    """Seed of the readings' noise and of the random faults."""

    @property
    def counts_per_rev(self) -> int:
        """Return the number of counts per turn."""
        return self.lines * self.interpolation

    @property
    def capture_depth(self) -> int:
        """Return the number of samples that a bank holds: the samples of a turn plus a margin,
        rounded up to a multiple of 512."""
        return -(-self.samples * 256 // (250 * DEPTH_STEP)) * DEPTH_STEP


class TableErrors(Struct, frozen=True, forbid_unknown_fields=True):
    """Errors of the table in addition to the named causes; they are the key ``[table]`` of the
    file."""

    errors: Literal["paper", "none"] = "paper"
    """Kind of error: ``paper`` for an error like the paper's, [−150.0″, 137.9″], or ``none`` for a
    perfect disc."""
    separation_error_arcsec: Annotated[float, Meta(ge=-3600, le=3600)] = 0.0
    """Difference of the true separation of the heads from the 33° that the firmware assumes."""
    noise_arcsec: Annotated[float, Meta(ge=0, le=100)] = 0.2
    """Standard deviation of each head's reading."""


class TemperaturePoint(Struct, frozen=True, forbid_unknown_fields=True):
    """Point of the temperature's course; it is an entry of ``[[temperature]]`` in the file."""

    celsius: Annotated[float, Meta(ge=-50, le=150)]
    at_turn: NotNegative = 0.0
    """Travel, in turns; the time ``after_s`` counts from the instant at which the table completes
    it."""
    after_s: Number = 0.0


@dataclass(frozen=True, slots=True)
class ScenarioCause:
    """Cause of the scenario file, in the form that the simulated table uses."""

    name: str
    physical: Cause
    reference_only: bool


@dataclass(frozen=True, slots=True)
class Fault:
    """Fault of pins, bus or processor that lasts for a part of the motion."""

    what: str
    """Kind of the fault: ``pins``, ``bus_stall`` or ``hung_processor``."""
    at_turn: float
    for_turns: float = 0.0
    for_s: float = 0.0
    """Duration in seconds of the motion; it is added to the duration ``for_turns``."""
    pins: int = 0
    act: str = "invert"
    probability: float = 1.0
    most_clocks: int = 0
    text: str = ""
    """Description of the fault for the result."""

    def span_s(self, course: Course) -> tuple[float, float]:
        """Return the first and the last instant of the fault, in the time of the motion."""
        begin = course.time_at_turn(self.at_turn)
        if not self.for_turns:
            return begin, begin + self.for_s
        return begin, course.time_at_turn(self.at_turn + self.for_turns) + self.for_s


@dataclass(frozen=True, slots=True)
class FirmwareSettings:
    """Settings of the firmware."""

    recalibrate: str = "every_turn"
    """Turns that the firmware calibrates: ``every_turn``, ``first_turn`` (then the coefficients are
    frozen) or ``never``."""
    orders: int = 32
    calculation_s: float = 0.25
    """Duration of a calibration, in the time of the table."""
    parameters: tuple[tuple[str, float], ...] = ()
    loaded: Coefficients | None = None
    """Coefficients that are loaded over the console at the start, as by ``arctrue load``."""
    thermometer: bool = False
    """Whether a thermometer is on the table; its resolution is 1/128 K, and it has no lag."""


TurnNumber = Annotated[int, Meta(ge=1)]
Count = Annotated[int, Meta(ge=0)]


class Limits(Struct, frozen=True, forbid_unknown_fields=True):
    """Limits that a run must keep to pass; they are the key ``[limits]`` of the file. A limit that
    is None is not checked."""

    from_turn: TurnNumber = 3
    to_turn: TurnNumber | None = None
    corrected_rms_arcsec: NotNegative | None = None
    corrected_reach_arcsec: NotNegative | None = None
    worse_by_arcsec: NotNegative | None = None
    """Largest permitted value of the corrected minus the uncorrected RMS, in any turn."""
    applied_turns_least: Count | None = None
    refused_turns_least: Count | None = None
    refused_turns_most: Count | None = None
    reasons_wanted: tuple[Reason, ...] = ()
    """Reasons, for refused captures or for kept coefficients, that must occur."""
    flags_wanted: tuple[Flag, ...] = ()
    flags_allowed: tuple[Flag, ...] | None = None

    def __post_init__(self) -> None:
        """Raise ValueError if the last turn comes before the first."""
        if self.to_turn is not None and self.to_turn < self.from_turn:
            raise ValueError(
                f"to_turn: expected {self.from_turn} (from_turn) or more, found {self.to_turn}"
            )

    def without_arcsec(self) -> Limits:
        """Return the limits, but without the limits that depend on the size of a count."""
        return structs.replace(
            self, corrected_rms_arcsec=None, corrected_reach_arcsec=None, worse_by_arcsec=None
        )


@dataclass(frozen=True, slots=True)
class Scenario:
    """Content of a scenario file."""

    title: str
    """Title of the scenario."""
    about: str
    """Purpose of the scenario in sentences."""
    scale: Scale
    """Size of disc, gateware and capture."""
    errors: TableErrors
    """Errors of the table in addition to the named causes."""
    legs: tuple[Leg, ...]
    """Parts of the motion, in their order."""
    ripple_rad: float = 0.0
    """Amplitude of the ripple of the angle, radians."""
    ripple_order: int = 7
    """Number of periods of the ripple per turn."""
    temperature: tuple[TemperaturePoint, ...] = ()
    """Points of the temperature's course; empty if the temperature does not change."""
    causes: tuple[ScenarioCause, ...] = ()
    """Physical causes that add errors to the table."""
    faults: tuple[Fault, ...] = ()
    """Faults of wires, bus and processor."""
    firmware: FirmwareSettings = field(default_factory=FirmwareSettings)
    """Settings of the firmware."""
    limits: Limits = field(default_factory=Limits)
    """Limits that the run must keep."""
    orders: tuple[int, ...] = (1, 2, 3)
    """Orders whose amplitudes are printed for each turn."""
    faces: int = FACES
    """Number of faces of the polygon, if a cause acts on the reference."""

    @property
    def speeds_rad_s(self) -> list[float]:
        """Return the speed of each leg that is not a pause."""
        return [leg.speed_rad_s for leg in self.legs if leg.turns]

    @property
    def clock_hz(self) -> float:
        """Return the number of gateware clocks per second in the time of the table."""
        return clock_hz_for(
            self.scale.counts_per_rev, max(self.speeds_rad_s), self.scale.clocks_per_count
        )

    @property
    def sample_period_clocks(self) -> int:
        """Return the number of clocks between two samples: at the slowest speed a turn has
        ``scale.samples`` samples."""
        turn_s = 2 * np.pi / min(self.speeds_rad_s)
        return round(turn_s * self.clock_hz / self.scale.samples)

    @property
    def revolution(self) -> RevolutionSettings:
        """Return the scale as settings of ``arctrue revolution``, which make the table with the
        paper's kind of error."""
        return RevolutionSettings(
            lines=self.scale.lines,
            interpolation=self.scale.interpolation,
            lanes=self.scale.lanes,
            samples=self.scale.samples,
            speed_deg_s=float(np.rad2deg(max(self.speeds_rad_s))),
            clocks_per_count=self.scale.clocks_per_count,
            orders=self.firmware.orders,
            noise_arcsec=0.0,
        )

    @property
    def kept_every(self) -> int:
        """Return the step between kept edges; it is odd, so that the kept edges cover every count
        of a line."""
        turns = sum(abs(leg.turns) for leg in self.legs)
        every = max(
            1,
            self.scale.counts_per_rev // EDGES_KEPT_A_TURN,
            math.ceil(turns * self.scale.counts_per_rev / EDGES_KEPT),
        )
        return every + 1 - every % 2

    @property
    def arcsec_per_count(self) -> float:
        """Return the size of a count in seconds of arc."""
        return ARCSEC_PER_TURN / self.scale.counts_per_rev

    def course(self) -> Course:
        """Return the motion with its temperature.

        Returns
        -------
        Course
            The legs of the scenario, one after the other.

        Raises
        ------
        ValueError
            If the motion cannot be driven.
        """
        bare = Course.over(
            self._legs_in_samples(), ripple_rad=self.ripple_rad, ripple_order=self.ripple_order
        )
        if not self.temperature:
            return bare
        points = sorted(
            (
                float(bare.surroundings_at(np.array([bare.time_at_turn(point.at_turn)]))[0])
                + point.after_s,
                point.celsius,
            )
            for point in self.temperature
        )
        times_s, temperatures_c = zip(*points, strict=True)
        return replace(bare, temperature=TemperatureCourse(times_s, temperatures_c))

    def _legs_in_samples(self) -> list[Leg]:
        """Return the legs; the simulated part of each pause is rounded to whole sample periods.

        Clock and sampler of the gateware then have the same phase relative to each other after the
        pause as without the pause.
        """
        if not self.speeds_rad_s:
            return list(self.legs)
        period_s = self.sample_period_clocks / self.clock_hz
        return [
            leg if leg.turns else replace(leg, run_s=max(1, round(leg.run_s / period_s)) * period_s)
            for leg in self.legs
        ]

    def table(self) -> RotaryTable:
        """Return the table with all its causes.

        Returns
        -------
        RotaryTable
            The table. The noise of the readings is its last cause.

        Raises
        ------
        ValueError
            If a value of a cause is outside its range.
        """
        causes: list[Cause] = []
        if self.errors.errors == "paper":
            plain = self.revolution.table().causes
            causes += [e for e in plain if isinstance(e, DiscEccentricity | GraduationHarmonics)]
        causes += [cause.physical for cause in self.causes if not cause.reference_only]
        if self.errors.noise_arcsec:
            # The noise of each sample is independent of the noise of the other samples.
            correlation_s = self.sample_period_clocks / self.clock_hz / 5
            rms_rad = self.errors.noise_arcsec * RAD_PER_ARCSEC
            causes.append(ReadingNoise(rms_rad, correlation_s, self.scale.seed))
        separation = HEAD_SEPARATION_RAD + self.errors.separation_error_arcsec * RAD_PER_ARCSEC
        return RotaryTable(
            heads=two_heads(separation_rad=separation),
            causes=tuple(causes),
            counts_per_rev=self.scale.counts_per_rev,
        )
