"""One revolution at the paper's size: capture, calibrate with the firmware, swap, and score.

The table has the paper's kind of error (section 4: [−150.0″, 137.9″]). Its first turn is captured
by the gateware and calibrated by the firmware's C; the second, compensated, is judged edge by
edge against the true angle, which nothing but the judge knows.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from arctrue.gateware.correction_ramp import ACCELERATION_MAX, ramp_arcsec_s, ramp_arcsec_s2
from arctrue.generated.number_formats import CLOCK_HZ, LANES_DEFAULT
from arctrue.generated.registers import REGISTERS
from arctrue.instrument.errors import InstrumentError
from arctrue.instrument.firmware import Firmware
from arctrue.instrument.instrument import Instrument, RunProgress, clock_hz_for
from arctrue.instrument.noise import ReadingNoise
from arctrue.instrument.recording import Recording
from arctrue.instrument.turn_score import FINE_BINS, TurnScore, score_turn
from arctrue.progress import ReportStep
from arctrue.table import (
    HEAD_SEPARATION_RAD,
    DiscEccentricity,
    GraduationHarmonics,
    Motion,
    RotaryTable,
    two_heads,
)
from arctrue.units import ARCSEC_PER_TURN, RAD_PER_ARCSEC

TURN_RAD = 2 * np.pi

PAPER_BEFORE_ARCSEC = (-150.0, 137.9)
PAPER_AFTER_ARCSEC = (-1.3, 1.6)
"""Section 4 of the paper: a polygon of 24 faces and an autocollimator, ten cycles."""

# An eccentricity of 37.7 µm is 144″ at a radius of 53.975 mm, and a second order of 6″ shifts both
# ends of the paper's range by −6″; the orders above it are a clamped disc's, their phases chosen so
# that the ends of the range are the paper's.
ECCENTRICITY_M = 37.7e-6
ECCENTRICITY_DIRECTION_RAD = 2.1
GRADUATION_ORDERS = (2, 3, 4, 5, 8, 12)
GRADUATION_ARCSEC = (6.0, 1.2, 0.7, 0.5, 0.35, 0.2)
GRADUATION_PHASES_RAD = (4.2, 3.1, 4.1, 4.8, 3.9, 4.6)

PAPER_COUNT_ARCSEC = ARCSEC_PER_TURN / (1 << 24)
_RUN_UP_RAD = float(np.deg2rad(1.0))
# A capture begins at the first sample after both indices; then a calculation and the ramp.
_SPARE_RAD = float(np.deg2rad(15.0))
# Of the bank over the bus; measured: 6.
_CLOCKS_A_READ = 8
DEPTH_STEP = 512
"""Half a degree: 23,302 edges at 2²⁴, in which noise averages out and slow errors do not."""


LARGEST_RAMP_ARCSEC_S = 1e9
LARGEST_RAMP_ARCSEC_S2 = 1e12
"""The largest that the firmware's parameters take: firmware/application/parameters.c."""


@dataclass(frozen=True, slots=True)
class RevolutionSettings:
    """The paper's conditions; smaller where a test needs it."""

    lines: int = 16384
    interpolation: int = 1024
    lanes: int = LANES_DEFAULT
    samples: int = 12000
    """Samples in a turn."""
    speed_deg_s: float = 30.0
    clocks_per_count: float = 1.1
    """The gateware's clock is slowed to so many clocks a count."""
    alpha_error_arcsec: float = 50.0
    """How far the heads' separation is from the 33° that the firmware is told."""
    noise_arcsec: float = 0.2
    """Standard deviation of each head's reading: the paper's repeatability."""
    ripple_rad: float = 0.002
    ripple_order: int = 7
    orders: int = 32
    """Orders that the firmware fits."""
    calculation_s: float = 0.25
    """What a calibration may take on the Cortex-A9, in the table's time."""
    limit_arcsec: float = 0.3
    seed: int = 1

    @property
    def capture_depth(self) -> int:
        """Samples that a bank holds: those of a turn and a margin, in steps of 512."""
        return -(-self.samples * 256 // (250 * DEPTH_STEP)) * DEPTH_STEP

    @property
    def counts_per_rev(self) -> int:
        """Counts a turn."""
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
        """Clocks of the gateware in a second of the table's time."""
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
        """The reset value's counts a second, in the table's time."""
        (register,) = [r for r in REGISTERS if r.path == "ramp_rate"]
        preset = register.fields[0].reset or 0
        return min(round(preset * CLOCK_HZ / self.clock_hz), 2**32 - 1)

    @property
    def ramp_acceleration(self) -> int:
        """The same of the ramp's acceleration: where time is compressed, so are its seconds.

        0, no bound, where the register cannot hold it: a smaller one would be a slower ramp.
        """
        (register,) = [r for r in REGISTERS if r.path == "ramp_acceleration"]
        preset = register.fields[0].reset or 0
        compressed = round(preset * (CLOCK_HZ / self.clock_hz) ** 2)
        return compressed if compressed <= ACCELERATION_MAX else 0

    @property
    def ramp_parameters(self) -> dict[str, float]:
        """Both as the firmware has them, and no more than it takes."""
        velocity = ramp_arcsec_s(self.ramp_rate, self.counts_per_rev)
        acceleration = ramp_arcsec_s2(self.ramp_acceleration, self.counts_per_rev)
        return {
            "ramp_arcsec_s": min(velocity, LARGEST_RAMP_ARCSEC_S),
            "ramp_arcsec_s2": min(acceleration, LARGEST_RAMP_ARCSEC_S2),
        }

    def table(self) -> RotaryTable:
        """The table with the paper's kind of error."""
        effects: list[Any] = [
            DiscEccentricity(ECCENTRICITY_M, ECCENTRICITY_DIRECTION_RAD),
            GraduationHarmonics(
                GRADUATION_ORDERS,
                tuple(arcsec * RAD_PER_ARCSEC for arcsec in GRADUATION_ARCSEC),
                GRADUATION_PHASES_RAD,
            ),
        ]
        if self.noise_arcsec:
            # Independent from one sample to the next.
            correlation_s = self.sample_period_clocks / self.clock_hz / 5
            effects.append(
                ReadingNoise(self.noise_arcsec * RAD_PER_ARCSEC, correlation_s, self.seed)
            )
        separation = HEAD_SEPARATION_RAD + self.alpha_error_arcsec * RAD_PER_ARCSEC
        return RotaryTable(
            heads=two_heads(separation_rad=separation),
            causes=tuple(effects),
            counts_per_rev=self.counts_per_rev,
        )

    def motion(self) -> Motion:
        """From rest over both indices and two turns and a half at one speed, with a ripple."""
        start = -HEAD_SEPARATION_RAD - 2 * _RUN_UP_RAD
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
        # The ramp works off twice the largest error at the most.
        largest_counts = 2 * max(-PAPER_BEFORE_ARCSEC[0], PAPER_BEFORE_ARCSEC[1])
        largest_counts /= self.arcsec_per_count
        rate, acceleration = self.ramp_rate * 2.0**-35, self.ramp_acceleration * 2.0**-59
        gathering = rate / acceleration if acceleration else 0.0
        ramp_s = (largest_counts / rate + gathering) / self.clock_hz
        read_s = 2 * self.samples * _CLOCKS_A_READ / self.clock_hz
        return (ramp_s + read_s + self.calculation_s) * self.speed_rad_s + 2 * _SPARE_RAD


@dataclass(frozen=True, slots=True)
class RevolutionResult:
    """What came of it."""

    settings: RevolutionSettings
    before: TurnScore
    after: TurnScore
    telemetry: dict[str, Any]
    """What the firmware told of the captured turn."""
    applied_orders: int
    latency_clocks: float
    clocks: int
    """Clocks of the gateware in all."""
    wall_s: float
    faults: tuple[str, ...]

    @property
    def limit_arcsec(self) -> float:
        """Allowed error of a bin: that of the settings at the paper's size.

        The output is within half a count of what it should be; larger counts add what they are
        larger by. Orders of the table for which there is no lane stay.
        """
        half_count = self.settings.arcsec_per_count / 2 - PAPER_COUNT_ARCSEC / 2
        without_lane = sum(GRADUATION_ARCSEC[self.settings.lanes - 1 :])
        return self.settings.limit_arcsec + half_count + without_lane

    def as_json(self) -> dict[str, Any]:
        """Everything as plain values."""
        return {
            "settings": asdict(self.settings),
            "counts_per_rev": self.settings.counts_per_rev,
            "paper": {"before_arcsec": PAPER_BEFORE_ARCSEC, "after_arcsec": PAPER_AFTER_ARCSEC},
            "before": {**self.before.as_json(), **self.before.curve_as_json()},
            "after": {**self.after.as_json(), **self.after.curve_as_json()},
            "limit_arcsec": self.limit_arcsec,
            "telemetry": self.telemetry,
            "applied_orders": self.applied_orders,
            "latency_clocks": self.latency_clocks,
            "clocks": self.clocks,
            "wall_s": self.wall_s,
            "clocks_per_s": self.clocks / self.wall_s,
            "faults": list(self.faults),
        }


def run_revolution(
    settings: RevolutionSettings,
    *,
    progress: Callable[[RunProgress], None] | None = None,
    say: ReportStep | None = None,
) -> RevolutionResult:
    """Run it; raises InstrumentError where the firmware does not come to a swap."""
    say = say or (lambda _: None)
    with Instrument(
        settings.lanes,
        settings.capture_depth,
        clock_hz=settings.clock_hz,
        progress=progress,
        say=say,
    ) as instrument:
        started = time.monotonic()
        instrument.attach(settings.table(), settings.motion())
        firmware = set_up(instrument.firmware, settings)
        poll = settings.poll_clocks
        firmware.run(
            until=lambda f: f.phase == "capture",
            stage="to the index of both heads",
            poll_clocks=poll,
        )

        before = _recorded_turn(instrument, settings, "first turn: captured, not corrected")
        firmware.run(
            until=lambda f: bool(f.telemetry) and settled(instrument, f),
            stage="calibration, swap and ramp",
            poll_clocks=poll,
        )
        told = firmware.telemetry[0]
        firmware.send("freeze on")

        after = _recorded_turn(instrument, settings, "second turn: corrected")
        coefficients = firmware.coefficients
        result = RevolutionResult(
            settings=settings,
            before=score_turn(before.output),
            after=score_turn(after.output),
            telemetry=told,
            applied_orders=0
            if coefficients is None
            else int(np.count_nonzero(coefficients.amplitudes)),
            latency_clocks=instrument.latency_clocks,
            clocks=instrument.clock,
            wall_s=time.monotonic() - started,
            faults=(),
        )
        return _with_faults(result, instrument, after.illegal)


def _recorded_turn(instrument: Instrument, settings: RevolutionSettings, stage: str) -> Recording:
    """Every edge of the next whole turn."""
    instrument.record(bins=FINE_BINS, turns=1.0)
    end = instrument.true_angle_rad + TURN_RAD
    instrument.firmware.run(
        until=lambda _: instrument.true_angle_rad >= end,
        stage=stage,
        poll_clocks=settings.poll_clocks,
    )
    return instrument.recording()


def set_up(firmware: Firmware, settings: RevolutionSettings) -> Firmware:
    """Tell the firmware of the table and start it."""
    for name, value in (
        ("counts_per_rev", settings.counts_per_rev),
        ("sample_period", settings.sample_period_clocks),
        *settings.ramp_parameters.items(),
        ("output_spacing", 1),
        ("orders", settings.orders),
    ):
        firmware.set(name, value)
    firmware.calculation_clocks = round(settings.calculation_s * settings.clock_hz)
    firmware.start()
    return firmware


def settled(instrument: Instrument, firmware: Firmware) -> bool:
    """Is the first turn's calibration applied, and its ramp over?

    Raises InstrumentError where the firmware did not apply it.
    """
    if firmware.telemetry[0]["result"] != "applied":
        told = firmware.telemetry[0]
        raise InstrumentError(
            f"the firmware did not apply the first turn: {told['result']}, {told['reason']}"
        )
    if firmware.phase != "capture":
        return False
    status = instrument.read_fields("status")
    return bool(status["compensating"] and not status["ramp_busy"])


def _with_faults(
    result: RevolutionResult, instrument: Instrument, illegal: int
) -> RevolutionResult:
    found = []
    reach = result.after.reach_arcsec
    if not reach <= result.limit_arcsec:
        found.append(
            f"the corrected error reaches {reach:.3f}″, the limit is {result.limit_arcsec:.3f}″"
        )
    if illegal:
        found.append(f"A and B of the output changed together in {illegal} clocks")
    for head in ("head1", "head2"):
        flags = instrument.read_fields(f"{head}.flags")
        raised = [name for name in ("index_error", "illegal", "overspeed") if flags[name]]
        if raised:
            found.append(f"{head}: {', '.join(raised)}")
    if instrument.read("status.cannot_keep_up"):
        found.append("the output could not keep up")
    return RevolutionResult(
        **{name: getattr(result, name) for name in result.__slots__ if name != "faults"},
        faults=tuple(found),
    )
