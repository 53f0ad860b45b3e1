"""Runs a scenario on the virtual instrument, turn by turn."""

from __future__ import annotations

import dataclasses
import time
from typing import Any

import numpy as np

from arctrue.base.progress import ReportStep
from arctrue.device.load import load_frames
from arctrue.gateware.coefficients import Coefficients
from arctrue.instrument import Instrument, InstrumentError, PinFault, ReportRun
from arctrue.instrument.turn_score import score_turns
from arctrue.studies.scenario.course import Course
from arctrue.studies.scenario.limits import broken_limits
from arctrue.studies.scenario.result import ScenarioResult, ScenarioTurn
from arctrue.studies.scenario.scenario import FLAGS, Scenario
from arctrue.studies.scenario.seen import seen_by_reference

LOOKS_A_TURN = 36
"""Number of times at which flags and telemetry are read in a turn at the largest speed."""
THERMOMETER_STEP_K = 1 / 128
"""Resolution of the simulated thermometer, a TMP117."""


class _Run:
    """State of one run of a scenario."""

    def __init__(self, instrument: Instrument, scenario: Scenario, course: Course) -> None:
        self.instrument, self.scenario, self.course = instrument, scenario, course
        self.started = instrument.clock
        self.flags: list[set[str]] = [set() for _ in range(self.rows)]
        self.telemetry: list[list[dict[str, Any]]] = [[] for _ in range(self.rows)]
        self.events: list[list[str]] = [[] for _ in range(self.rows)]
        self.banks: list[Coefficients | None] = [None for _ in range(self.rows)]
        self._heard = 0
        self._stalled = 0
        self._firmware_held = False
        for fault in scenario.faults:
            self.events[self._row_of(fault.at_turn)].append(fault.text)
        self._note_pauses()

    @property
    def rows(self) -> int:
        """Return the number of turns of travel; the last turn may be incomplete."""
        return max(1, int(np.ceil(self.course.turns - 1e-6)))

    def _row_of(self, turn: float) -> int:
        return int(np.clip(np.floor(turn + 1e-9), 0, self.rows - 1))

    def _note_pauses(self) -> None:
        turn = 0.0
        for before, leg in zip((None, *self.scenario.legs), self.scenario.legs, strict=False):
            # Events exactly at the end of the last turn belong to the row of the last turn.
            row = self._row_of(turn)
            if not leg.turns:
                self.events[row].append(f"pause of {leg.pause_s:g} s")
            elif before is not None and before.turns * leg.turns < 0:
                self.events[row].append("reversal")
            turn += abs(leg.turns)

    def clock_at(self, motion_s: float) -> int:
        """Return the clock at an instant of the motion."""
        return self.started + round(motion_s * self.instrument.clock_hz)

    def row_now(self) -> int:
        """Return the index of the turn at the present clock."""
        now_s = (self.instrument.clock - self.started) / self.instrument.clock_hz
        return self._row_of(float(self.course.travel_turns(np.array([now_s]))[0]))

    def spans(self, what: str) -> list[tuple[int, int, int]]:
        """Return first clock, last clock and longest stall of each fault of one kind."""
        return [
            (self.clock_at(begin), max(self.clock_at(begin) + 1, self.clock_at(end)), f.most_clocks)
            for f in self.scenario.faults
            if f.what == what
            for begin, end in (f.span_s(self.course),)
        ]

    def lay_pin_faults(self) -> None:
        """Pass all faults of pins, with their clocks, to the instrument."""
        found = []
        for fault in self.scenario.faults:
            if fault.what != "pins":
                continue
            begin, end = (self.clock_at(instant) for instant in fault.span_s(self.course))
            acts = {fault.act: fault.pins}
            found.append(
                PinFault(
                    begin,
                    max(1, end - begin),
                    **acts,
                    probability=fault.probability,
                )
            )
        if found:
            self.instrument.disturb(*found, seed=self.scenario.scale.seed)

    def look(self) -> None:
        """Store raised flags, active coefficients and new telemetry in the row of the present
        turn."""
        row = self.row_now()
        for head in ("head1", "head2"):
            fields = self.instrument.read_fields(f"{head}.flags")
            self.flags[row] |= {f"{head}.{name}" for name, value in fields.items() if value}
        if self.instrument.read("status.cannot_keep_up"):
            self.flags[row].add("status.cannot_keep_up")
        self.flags[row] &= set(FLAGS)
        self.banks[row] = self.instrument.firmware.active_bank(self.scenario.scale.counts_per_rev)
        telemetry = self.instrument.firmware.telemetry
        self.telemetry[row] += telemetry[self._heard :]
        self._heard = len(telemetry)

    def thermometer_c(self) -> float:
        """Return the present value of the thermometer on the table."""
        now_s = (self.instrument.clock - self.started) / self.instrument.clock_hz
        instant = min(max(now_s, 0.0), self.course.duration_s)
        celsius = float(self.course.temperature_c(np.array([instant]))[0])
        return round(celsius / THERMOMETER_STEP_K) * THERMOMETER_STEP_K

    def freeze_when_wanted(self) -> None:
        """If the scenario requires it, freeze the coefficients as soon as the first coefficients
        are applied."""
        applied = any(t["result"] == "applied" for t in self.instrument.firmware.telemetry)
        firmware = self.scenario.firmware
        if firmware.recalibrate == "first_turn" and applied and not self._firmware_held:
            self._firmware_held = True
            self.instrument.firmware.send("freeze on")

    def go(self, poll_clocks: int) -> None:
        """Run the whole motion with its faults."""
        instrument = self.instrument
        hung, stalls = self.spans("hung_processor"), self.spans("bus_stall")
        edges = sorted({clock for begin, end, _ in (*hung, *stalls) for clock in (begin, end)})
        turn_s = 2 * np.pi / max(self.scenario.speeds_rad_s)
        between = max(poll_clocks, round(turn_s * instrument.clock_hz / LOOKS_A_TURN))
        end = self.clock_at(self.course.duration_s)
        while instrument.clock < end:
            now = instrument.clock
            until = min([now + between, end, *(edge for edge in edges if edge > now)])
            most = max((most for begin, last, most in stalls if begin <= now < last), default=0)
            if most != self._stalled:
                instrument.stall_bus(most, self.scenario.scale.seed)
                self._stalled = most
            stage = f"turn {self.row_now() + 1} of {self.rows}"
            if any(begin <= now < last for begin, last, _ in hung):
                instrument.run(until - now, stage=stage)
            else:
                instrument.firmware.run(until - now, poll_clocks=poll_clocks, stage=stage)
                self.freeze_when_wanted()
            self.look()


def run_scenario(
    scenario: Scenario,
    *,
    report_run: ReportRun | None = None,
    report_step: ReportStep | None = None,
) -> ScenarioResult:
    """Run a scenario on the virtual instrument.

    Parameters
    ----------
    scenario : Scenario
        Table, motion, firmware and faults.
    report_run : callable, optional
        Function that receives the progress of the run every few seconds.
    report_step : callable, optional
        Function that receives a line of text at each step in which the instrument is built.

    Returns
    -------
    ScenarioResult
        All turns, and the limits that the run exceeded.

    Raises
    ------
    InstrumentError
        If the instrument cannot be built, a head finds no index, or the recording is too small.
    ValueError
        If the motion cannot be driven.
    """
    course, scale = scenario.course(), scenario.scale
    with Instrument(
        scale.lanes,
        scale.capture_depth,
        clock_hz=scenario.clock_hz,
        report_run=report_run,
        report_step=report_step,
    ) as instrument:
        began = time.monotonic()
        run = _Run(instrument, scenario, course)
        instrument.attach(scenario.table(), course)
        run.lay_pin_faults()
        poll = scenario.revolution.poll_clocks
        _set_up(instrument, scenario)
        if scenario.firmware.thermometer:
            instrument.firmware.thermometer = run.thermometer_c
        first = run.clock_at(course.time_at_turn(0.0))
        while instrument.clock < first:
            instrument.firmware.run(
                min(poll, first - instrument.clock), poll_clocks=poll, stage="over the indices"
            )
        if instrument.firmware.phase == "wait_for_index":
            raise InstrumentError(
                "a head did not find its index before the first turn; "
                "are there enough counts a turn (scale.lines, --lines)?"
            )
        instrument.record(every=scenario.kept_every)
        run.go(poll)
        run.look()
        recording = instrument.recording()
        errors = {}
        for name, track in (("head1", recording.head1), ("output", recording.output)):
            if track.dropped:
                raise InstrumentError(
                    f"{track.dropped} edges did not fit the recording: make the motion shorter"
                )
            edge_s = (track.clock - run.started) / instrument.clock_hz
            errors[name] = score_turns(track, course.travel_turns(edge_s), run.rows)
        middle_s = np.array(
            [course.time_at_turn(min(n + 0.5, course.turns)) for n in range(run.rows)]
        )
        temperature_c = course.temperature_c(middle_s)
        turns = tuple(
            ScenarioTurn(
                number=n + 1,
                temperature_c=float(temperature_c[n]),
                uncorrected=errors["head1"][n],
                corrected=errors["output"][n],
                reference=seen_by_reference(scenario, course, n + 1, errors["output"][n]),
                telemetry=tuple(run.telemetry[n]),
                flags=tuple(sorted(run.flags[n])),
                events=tuple(run.events[n]),
                bank=run.banks[n],
            )
            for n in range(run.rows)
        )
        result = ScenarioResult(
            scenario, turns, recording.illegal, instrument.clock, time.monotonic() - began
        )
    return dataclasses.replace(result, broken=broken_limits(result))


def _set_up(instrument: Instrument, scenario: Scenario) -> None:
    """Set the firmware's parameters, start the firmware, and load the scenario's coefficients, if
    any."""
    firmware, given = instrument.firmware, scenario.firmware
    for name, value in (
        ("counts_per_rev", scenario.scale.counts_per_rev),
        ("sample_period", scenario.sample_period_clocks),
        *scenario.revolution.ramp_parameters.items(),
        ("output_spacing", 1),
        ("orders", scenario.firmware.orders),
        *scenario.firmware.parameters,
    ):
        firmware.set(name, value)
    firmware.calculation_clocks = round(scenario.firmware.calculation_s * instrument.clock_hz)
    firmware.start()
    for line in load_frames(given.loaded) if given.loaded is not None else ():
        answer = firmware.send(line).strip()
        if not answer.startswith("ok"):
            raise InstrumentError(f"the firmware does not take the coefficients: {answer}")
    if scenario.firmware.recalibrate == "never":
        firmware.send("freeze on")
