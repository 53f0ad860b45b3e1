"""Simulates two turns of a table of the paper's size; the firmware calibrates between them.

The table has the paper's kind of error (section 4: [−150.0″, 137.9″]). The gateware captures the
first turn; the firmware's C code calibrates, loads the coefficients and swaps the banks. The second
turn is compensated. This module compares the output of both turns edge by edge with the true angle;
only this comparison uses the true angle.
"""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from arctrue.base.progress import ReportStep
from arctrue.instrument.errors import InstrumentError
from arctrue.instrument.firmware import Firmware
from arctrue.instrument.instrument import Instrument
from arctrue.instrument.recording import Recording
from arctrue.instrument.run_progress import ReportRun
from arctrue.instrument.turn_score import FINE_BINS, TurnScore, score_turn
from arctrue.studies.revolution.settings import (
    GRADUATION_ARCSEC,
    PAPER_AFTER_ARCSEC,
    PAPER_BEFORE_ARCSEC,
    PAPER_COUNT_ARCSEC,
    TURN_RAD,
    RevolutionSettings,
)


@dataclass(frozen=True, slots=True)
class RevolutionResult:
    """Result of the two turns: errors, telemetry, clocks and faults."""

    settings: RevolutionSettings
    """Settings of the run."""
    before: TurnScore
    """Error of the output in the turn that is captured and not yet corrected."""
    after: TurnScore
    """Error of the output in the corrected turn."""
    telemetry: dict[str, Any]
    """Telemetry of the firmware for the captured turn."""
    applied_orders: int
    """Number of orders that the firmware corrects."""
    latency_clocks: float
    """Clocks from an edge of head 1 to the same edge at the output."""
    clocks: int
    """Total clocks of the gateware."""
    wall_s: float
    """Duration of the run on this computer, seconds."""
    faults: tuple[str, ...]
    """Descriptions of the faults in the result; empty: none."""

    @property
    def limit_arcsec(self) -> float:
        """Largest permitted error of the corrected turn, averaged over half a degree, arcsec; at
        the paper's size it equals ``limit_arcsec`` of the settings.

        The output is within half a count of its target, so that larger counts increase the limit by
        half of their excess over the paper's count. Orders of the table's error for which there is
        no lane are not corrected; the limit also includes their amplitudes.
        """
        half_count = self.settings.arcsec_per_count / 2 - PAPER_COUNT_ARCSEC / 2
        without_lane = sum(GRADUATION_ARCSEC[self.settings.lanes - 1 :])
        return self.settings.limit_arcsec + half_count + without_lane

    def as_json(self) -> dict[str, Any]:
        """Return the whole result as plain values.

        Returns
        -------
        dict
            Settings, both errors with their curves, telemetry, clocks and faults.
        """
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
    report_run: ReportRun | None = None,
    report_step: ReportStep | None = None,
) -> RevolutionResult:
    """Run one turn before and one turn after the calibration on the virtual instrument.

    Parameters
    ----------
    settings : RevolutionSettings
        Table, motion, gateware and firmware.
    report_run : callable, optional
        Function that receives the progress of the run every few seconds.
    report_step : callable, optional
        Function that receives a line of text at each step in which the instrument is built.

    Returns
    -------
    RevolutionResult
        The errors of both turns, and descriptions of any faults.

    Raises
    ------
    InstrumentError
        If the instrument cannot be built, or the firmware does not apply the first turn.
    """
    report_step = report_step or (lambda _: None)
    with Instrument(
        settings.lanes,
        settings.capture_depth,
        clock_hz=settings.clock_hz,
        generics={"HEADS": settings.heads} if settings.heads > 2 else None,
        report_run=report_run,
        report_step=report_step,
    ) as instrument:
        started = time.monotonic()
        instrument.attach(settings.table(), settings.motion())
        firmware = set_up(instrument.firmware, settings)
        poll = settings.poll_clocks
        firmware.run(
            until=lambda f: f.phase == "capture",
            stage="until all heads have passed their index",
            poll_clocks=poll,
        )

        before = _recorded_turn(instrument, settings, "first turn: captured, not corrected")
        firmware.run(
            until=lambda f: bool(f.telemetry) and settled(instrument, f),
            stage="calibration, swap and ramp",
            poll_clocks=poll,
        )
        telemetry = firmware.telemetry[0]
        firmware.send("freeze on")

        after = _recorded_turn(instrument, settings, "second turn: corrected")
        coefficients = firmware.coefficients
        result = RevolutionResult(
            settings=settings,
            before=score_turn(before.output),
            after=score_turn(after.output),
            telemetry=telemetry,
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
    """Run the next whole turn and record every edge."""
    instrument.record(bins=FINE_BINS, turns=1.0)
    end = instrument.true_angle_rad + TURN_RAD
    instrument.firmware.run(
        until=lambda _: instrument.true_angle_rad >= end,
        stage=stage,
        poll_clocks=settings.poll_clocks,
    )
    return instrument.recording()


def set_up(firmware: Firmware, settings: RevolutionSettings) -> Firmware:
    """Send the table's parameters to the firmware and start it.

    Parameters
    ----------
    firmware : Firmware
        The firmware of an instrument.
    settings : RevolutionSettings
        Settings with counts, samples, ramp and orders.

    Returns
    -------
    Firmware
        The same firmware after its start.

    Raises
    ------
    InstrumentError
        If the firmware refuses a parameter or the core.
    """
    for name, value in (
        ("counts_per_rev", settings.counts_per_rev),
        ("sample_period", settings.sample_period_clocks),
        *settings.ramp_parameters.items(),
        ("output_spacing", 1),
        ("orders", settings.orders),
        *zip(("separation_deg", "head3_deg", "head4_deg"), settings.places_deg[1:], strict=False),
    ):
        firmware.set(name, value)
    firmware.calculation_clocks = round(settings.calculation_s * settings.clock_hz)
    firmware.start()
    return firmware


def settled(instrument: Instrument, firmware: Firmware) -> bool:
    """Tell whether the firmware has applied the first turn's calibration and the ramp has ended.

    Parameters
    ----------
    instrument : Instrument
        Instrument whose status is read.
    firmware : Firmware
        Firmware of the instrument, with the telemetry of one turn or more.

    Returns
    -------
    bool
        Whether the output is fully corrected.

    Raises
    ------
    InstrumentError
        If the firmware did not apply the first turn.
    """
    if firmware.telemetry[0]["result"] != "applied":
        telemetry = firmware.telemetry[0]
        raise InstrumentError(
            f"the firmware did not apply the first turn: {telemetry['result']}, "
            f"{telemetry['reason']}"
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
    for head in ("head1", "head2", "head3", "head4")[: result.settings.heads]:
        flags = instrument.read_fields(f"{head}.flags")
        raised = [name for name in ("index_error", "illegal", "overspeed") if flags[name]]
        if raised:
            found.append(f"{head}: {', '.join(raised)}")
    if instrument.read("status.cannot_keep_up"):
        found.append("the output could not follow the speed of the table")
    return RevolutionResult(
        **{name: getattr(result, name) for name in result.__slots__ if name != "faults"},
        faults=tuple(found),
    )
