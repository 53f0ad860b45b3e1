"""Simulates an instrument with three or four heads: the mean is calibrated from a capture; then an
effect disturbs the table."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from arctrue.base.progress import ReportStep
from arctrue.base.units import ARCSEC_PER_DEG, ARCSEC_PER_TURN
from arctrue.calibration.heads_calibration import MeanSettings, calibrate_mean
from arctrue.device.dump import read_head, read_row
from arctrue.device.load import load_frames
from arctrue.gateware.coefficients import Coefficients
from arctrue.instrument import Instrument, InstrumentError, ReportRun
from arctrue.instrument.recording import EdgeTrack
from arctrue.measurement import MeasurementSet
from arctrue.studies.heads.cases import HeadsCase
from arctrue.studies.heads.self_calibrated_table import PLACES_DEG
from arctrue.studies.revolution import ECCENTRICITY_DIRECTION_RAD, ECCENTRICITY_M
from arctrue.studies.revolution.settings import RevolutionSettings
from arctrue.table import (
    Cause,
    DiscEccentricity,
    GraduationHarmonics,
    Motion,
    RotaryTable,
    heads_at,
)
from arctrue.table.conditions import USUAL_TEMPERATURE_C
from arctrue.table.temperature import TemperatureCourse

Float = NDArray[np.float64]

GRADUATION_ARCSEC = {2: 1.6, 5: 0.9}
"""Amplitudes of the disc's graduation orders, by order."""
RECORDED_TURNS = 3.0
"""Length of a recording; over three turns the balls' order 4.37 is nearly orthogonal to the integer
orders of the disc."""
KEPT_EVERY = 16
"""Interval of the kept edges: the recording keeps every 16th edge."""
MOST_ORDER = 8
MOTION_TURNS = 30.0
START_RAD = -0.2


@dataclass(frozen=True)
class Track:
    """Angles of the table, and the error of a signal at these angles up to a constant; arrays
    (n,)."""

    angle_rad: Float
    error_arcsec: Float

    @classmethod
    def of(cls, edges: EdgeTrack) -> Track:
        """Compute the error at each edge that the recording keeps."""
        turn = edges.true_angle_rad / (2.0 * np.pi)
        counts = edges.position - turn * edges.counts_per_rev
        arcsec = ARCSEC_PER_TURN / edges.counts_per_rev
        return cls(edges.true_angle_rad, np.asarray((counts - counts.mean()) * arcsec))

    def line(self, order: float) -> complex:
        """Return the complex amplitude of an order in arcseconds; the fit also contains the integer
        orders 0 to 8."""
        columns = [np.ones(self.angle_rad.size)]
        for n in (order, *(n for n in range(1, MOST_ORDER + 1) if n != order)):
            columns += [np.cos(n * self.angle_rad), np.sin(n * self.angle_rad)]
        found, *_ = np.linalg.lstsq(np.stack(columns, axis=1), self.error_arcsec, rcond=None)
        return complex(found[1], -found[2])


class HeadsDevice:
    """Virtual instrument with three or four heads: the compiled core, the firmware on its bus, and
    a table under its heads.

    The class is a context manager. The disc has ECCENTRICITY_M and GRADUATION_ARCSEC.
    """

    def __init__(
        self,
        settings: RevolutionSettings,
        *,
        places_deg: tuple[float, ...] = PLACES_DEG,
        failover: bool = False,
        report_run: ReportRun | None = None,
        report_step: ReportStep | None = None,
    ) -> None:
        """Build the instrument, with one head at each of ``places_deg``, if it has not been built.
        Raises InstrumentError if the build fails.

        With ``failover`` the core continues with the mean of the other heads if a head fails.
        """
        self.settings = settings
        self.places_deg = places_deg
        self.failover = failover
        self.instrument = Instrument(
            settings.lanes,
            settings.capture_depth,
            clock_hz=settings.clock_hz,
            generics={"HEADS": len(places_deg), **({"FAILOVER": "true"} if failover else {})},
            report_run=report_run,
            report_step=report_step,
        )
        self.firmware = self.instrument.firmware
        for name, value in (
            ("counts_per_rev", settings.counts_per_rev),
            ("sample_period", settings.sample_period_clocks),
            *settings.ramp_parameters.items(),
            ("output_spacing", 1),
            ("orders", settings.orders),
            ("separation_deg", places_deg[1]),
            # The rounding to whole counts also contributes to the stated noise.
            ("alarm_noise_arcsec", max(1.0, settings.arcsec_per_count)),
        ):
            self.firmware.set(name, value)

    def calibrate_alone(self, *, on: bool = True) -> None:
        """Set the places of heads 3 and 4 in the firmware, so that the firmware can calibrate the
        mean by itself; without ``on``, set them to 0, which prevents this."""
        for head, place in enumerate(self.places_deg[2:], start=3):
            self.firmware.set(f"head{head}_deg", place if on else 0.0)

    def __enter__(self) -> Self:
        """Return the device itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Free the memory of the instrument."""
        self.instrument.close()

    def table(self, *causes: Cause) -> RotaryTable:
        """Return the instrument's table with further ``causes``."""
        orders = tuple(GRADUATION_ARCSEC)
        amplitudes = tuple(float(np.radians(GRADUATION_ARCSEC[n] / ARCSEC_PER_DEG)) for n in orders)
        disc = (
            DiscEccentricity(ECCENTRICITY_M, ECCENTRICITY_DIRECTION_RAD),
            GraduationHarmonics(orders, amplitudes, (0.4, 1.9)),
        )
        return RotaryTable(
            heads_at(np.radians(self.places_deg).tolist()),
            (*disc, *causes),
            counts_per_rev=self.settings.counts_per_rev,
            rounding="nearest",
        )

    def attach(self, *causes: Cause, celsius: float = USUAL_TEMPERATURE_C) -> None:
        """Attach to the heads a turning table with these causes, at one temperature."""
        speed = self.settings.speed_rad_s
        motion = Motion.steady(speed, MOTION_TURNS * 2.0 * np.pi / speed, start_rad=START_RAD)
        course = TemperatureCourse(temperatures_c=(celsius,))
        motion = dataclasses.replace(motion, temperature=course)
        self.instrument.attach(self.table(*causes), motion)

    def turn_before(self, *causes: Cause, celsius: float = USUAL_TEMPERATURE_C) -> None:
        """Attach like :meth:`attach`; the firmware then starts anew and finds the indices again."""
        self.attach(*causes, celsius=celsius)
        self.firmware.start()

    def run_until(self, reached: Callable[[], object], stage: str = "") -> None:
        """Run until ``reached`` is true. Raises InstrumentError if the motion ends before."""
        poll = self.settings.poll_clocks
        self.firmware.run(until=lambda _: reached(), poll_clocks=poll, stage=stage)

    def accepted_turn(self) -> dict[str, Any]:
        """Return the telemetry line of the next accepted turn."""
        first = len(self.firmware.telemetry)

        def accepted() -> list[dict[str, Any]]:
            new = self.firmware.telemetry[first:]
            return [line for line in new if line["result"] in ("applied", "kept")]

        self.run_until(accepted, "a turn that is accepted")
        return accepted()[0]

    def dumped(self) -> MeasurementSet:
        """Read one capture from the console. Raises InstrumentError if rows are missing."""
        self.firmware.send("dump")
        said = ""
        while "end of dump" not in said:
            self.instrument.run(self.settings.poll_clocks, stage="capture and dump")
            said += self.firmware.step() + "\n"
        lines = [line.strip() for line in said.splitlines()]
        heads = [found for line in lines if (found := read_head(line)) is not None]
        rows = {row[0]: row[1:] for line in lines if (row := read_row(line)) is not None}
        if len(heads) != 1 or heads[0].missing(rows):
            raise InstrumentError("rows of the capture that the console printed are missing")
        return heads[0].measurement(rows, "the instrument")

    def load(self, coefficients: Coefficients) -> str:
        """Send the coefficients to the console frame by frame, wait for the turn that tests them,
        and return the state of the load.

        Raises InstrumentError for a frame that the console refuses.
        """
        for frame in load_frames(coefficients, sets=self.failover):
            answer = self.firmware.send(frame).strip()
            if answer != "ok":
                raise InstrumentError(f"{frame}: the device answers {answer}")
        self.run_until(lambda: "load waiting" not in self.firmware.send("load status"), "judged")
        return self.firmware.send("load status").splitlines()[0].strip()

    def record(self) -> tuple[Track, Track]:
        """Record the errors of the output and of head 1's readings over RECORDED_TURNS turns."""
        self.run_until(lambda: not self.instrument.read("status.ramp_busy"), "the ramp")
        self.instrument.record(every=KEPT_EVERY, turns=RECORDED_TURNS)
        end = self.instrument.true_angle_rad + RECORDED_TURNS * 2.0 * np.pi
        self.run_until(lambda: self.instrument.true_angle_rad >= end, "fresh turns")
        recording = self.instrument.recording()
        return Track.of(recording.output), Track.of(recording.head1)


@dataclass(frozen=True)
class HeadsResult:
    """Amplitudes, in arcseconds, by which an effect changes two signals at the order of the
    case."""

    case: HeadsCase
    counts_per_rev: int
    head1_arcsec: float
    """Amplitude in head 1; a correction from two heads would not remove it."""
    mean_arcsec: float
    """Amplitude in the mean of four heads."""
    clocks: int

    def as_json(self) -> dict[str, Any]:
        """Return the result as plain values."""
        return {
            "title": self.case.title,
            "order": self.case.order,
            "counts_per_rev": self.counts_per_rev,
            "head1_arcsec": self.head1_arcsec,
            "mean_arcsec": self.mean_arcsec,
            "clocks": self.clocks,
        }


def run_on_heads(
    case: HeadsCase,
    settings: RevolutionSettings,
    *,
    report_run: ReportRun | None = None,
    report_step: ReportStep | None = None,
) -> HeadsResult:
    """Calibrate the mean of four heads from one capture, then add the effect without a new
    calibration, and measure how it changes both signals.

    Raises InstrumentError if the device refuses the mean or does not return to the mean.
    """
    with HeadsDevice(settings, report_run=report_run, report_step=report_step) as device:
        device.turn_before()
        device.accepted_turn()
        found = calibrate_mean(
            device.dumped(), MeanSettings(most_order=MOST_ORDER, lanes=settings.lanes, motion=())
        )
        if (state := device.load(found.coefficients)) != "load active":
            raise InstrumentError(f"the device does not take the mean: {state}")
        before = device.record()
        device.turn_before(case.cause, celsius=case.celsius)
        if "mean_of_heads" not in device.accepted_turn():
            raise InstrumentError("the mean is not active after the restart")
        after = device.record()
        mean, head1 = (
            abs(late.line(case.order) - early.line(case.order))
            for late, early in zip(after, before, strict=True)
        )
        return HeadsResult(case, settings.counts_per_rev, head1, mean, device.instrument.clock)
