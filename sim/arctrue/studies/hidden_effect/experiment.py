"""Runs an experiment: measures a table with a hidden effect, diagnoses the effect, and measures the
corrected output."""

from __future__ import annotations

import dataclasses
import time
from pathlib import Path

import numpy as np

from arctrue.base.progress import ReportStep
from arctrue.gateware.coefficient_file import write_coefficient_file
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.phase_sources import with_phase_from_probe
from arctrue.instrument import Instrument, InstrumentError, Recording, ReportRun
from arctrue.instrument.turn_score import score_turn
from arctrue.measurement import Reference
from arctrue.studies.hidden_effect.cases import Case, RunPlan
from arctrue.studies.hidden_effect.drive import (
    TURN_RAD,
    and_back,
    over_stations,
    turning,
    with_second_speed,
)
from arctrue.studies.hidden_effect.measured import seal, write_set
from arctrue.studies.hidden_effect.reference import (
    Readings,
    as_reference,
    counts_standing,
    on_the_move,
    zero_level,
)
from arctrue.studies.hidden_effect.result import HiddenResult
from arctrue.studies.hidden_effect.rig import CapturedTurn, Rig
from arctrue.studies.hidden_effect.settings import HiddenSettings
from arctrue.studies.hidden_effect.signal_period import signal_period
from arctrue.studies.hidden_effect.workbench import (
    DiagnosedModel,
    diagnose_and_add,
    left_on_fresh_set,
)
from arctrue.table import Motion
from arctrue.workbench.model.export import Export
from arctrue.workbench.model.followed_lanes import ConditionSettings

STOP_CLOCKS = 2000
"""Number of clocks for which the table stands at a station of the polygon: far more than the
latency."""
FURTHER_TURNS = 0.4
"""Number of turns of a drive after the captured turns; in these the calibration, the ramp and the
last turn are completed."""
NOMINAL_SHARE = 1.1
"""Nominal speed of the modulators, divided by the speed of the drive. The margin is far larger than
the ripple of the speed."""
ADOPTED = "found_on_this_table"
LINES_TURNS = 2
"""Number of turns over which lines of real orders (orders that need not be integers) are fitted:
over two turns, half orders are orthogonal to integer orders."""
WHOLE_ORDERS = 16
"""Number of integer orders that are fitted together with the lines of real orders."""
TURNS_BACK = 2.6


def run_hidden(
    case: Case,
    settings: HiddenSettings,
    folder: Path,
    *,
    report_run: ReportRun | None = None,
    report_step: ReportStep | None = None,
) -> HiddenResult:
    """Run the experiment with its files in ``folder``.

    Raises InstrumentError if tools are missing or the firmware does not reach a swap.
    """
    settings = _settings_of(case, settings)
    scale = settings.revolution
    with Instrument(
        scale.lanes,
        scale.capture_depth,
        clock_hz=scale.clock_hz,
        generics=_generics_of(case),
        report_run=report_run,
        report_step=report_step,
    ) as instrument:
        return _Run(case, settings, folder, instrument, report_step or (lambda _: None)).result()


def _settings_of(case: Case, settings: HiddenSettings) -> HiddenSettings:
    lanes = max(settings.revolution.lanes, case.least_lanes)
    return dataclasses.replace(
        settings, revolution=dataclasses.replace(settings.revolution, lanes=lanes)
    )


def _generics_of(case: Case) -> dict[str, str]:
    built = {
        "MODULATORS": case.modulators,
        "LOCAL_TABLE": case.local_table,
        "REAL_ORDERS": case.real_orders,
    }
    return {name: "true" for name, is_built in built.items() if is_built}


def without_extensions(coefficients: Coefficients) -> Coefficients:
    """Return the coefficients with amplitude 0 in the lanes that follow a condition or have a real
    order, and with an empty local table."""
    extension = coefficients.extension
    amplitudes = coefficients.amplitudes.copy()
    if extension is not None:
        amplitudes[[lane for lane, _ in (*extension.modulators, *extension.turn_steps)]] = 0
        if extension.local_table is not None:
            empty = dataclasses.replace(extension.local_table, points=())
            extension = dataclasses.replace(extension, local_table=empty)
    return dataclasses.replace(coefficients, amplitudes=amplitudes, extension=extension)


class _Run:
    def __init__(
        self,
        case: Case,
        settings: HiddenSettings,
        folder: Path,
        instrument: Instrument,
        report_step: ReportStep,
    ) -> None:
        self.case, self.settings, self.folder, self.report_step = (
            case,
            settings,
            folder,
            report_step,
        )
        self.causes = case.build(settings)
        scale = settings.revolution
        # The sample period is chosen so that a turn at the slowest speed has the stated number of
        # samples.
        samples = round(scale.samples * case.slowest)
        sampled = dataclasses.replace(
            settings, revolution=dataclasses.replace(scale, samples=samples)
        )
        self.rig = Rig(instrument, settings.table(self.causes), sampled)
        self.random = np.random.default_rng(settings.seed)
        self.runs: list[list[CapturedTurn]] = []
        self.references: list[Reference] = []

    def result(self) -> HiddenResult:
        """Measure the table, run the diagnosis, load the exported coefficients, and measure the
        output again."""
        started = time.monotonic()
        case, rig, settings = self.case, self.rig, self.settings
        paper_bank = self._first_run()
        paper = None
        if self._goes_on:
            paper = rig.instrument.recording()
        for number, plan in enumerate(case.further, start=2):
            self._further_run(plan, number)
        if case.polygon:
            self._polygon("the polygon, head by head", None)
        measured = self.folder / "measured"
        write_set(
            measured,
            "what the gateware measured",
            settings,
            self.runs,
            self.references,
            case.drive_gear_teeth,
        )
        seal(measured, case.name, self.causes)

        before_workbench = time.monotonic()
        diagnosed, export = self._diagnosed(measured)
        workbench_s = time.monotonic() - before_workbench

        if paper is None:
            self._fresh_power_up()
            rig.load(paper_bank, "the firmware's coefficients")
            paper = rig.recorded_turn("fresh turn with the paper's model")
        unit_left_out = None
        lines_counts: dict[str, list[float]] = {}
        if (case.modulators or case.local_table or case.real_orders) and not case.polygon:
            stage = "fresh turn without the unit that corrects the effect"
            rig.load(without_extensions(export.coefficients), stage)
            without = rig.recorded_turn(stage, turns=LINES_TURNS if case.lines else 1)
            unit_left_out = score_turn(without.output)
            lines_counts |= self._lines("without", without)
        if case.probe is not None:
            rig.give_index_of_drive(case.probe)
            rig.instrument.firmware.send("freeze off")
            rig.load_with_index_of_drive(
                with_phase_from_probe(
                    export.coefficients, case.probe.first_turns, case.probe.per_turn
                ),
                "an index of the drive gives the phases",
            )
        elif case.real_orders:
            # The operator states which turn of the core is turn 0 of the measurement set.
            rig.load(
                export.coefficients.from_turn(rig.first_turn_number()),
                "swap to the exported coefficients",
            )
        elif self._goes_on or case.local_table:
            # The file is sent over the console, as an operator would do; the calibration continues.
            rig.instrument.firmware.send("freeze off")
            rig.load_over_console(export.coefficients, "a turn judges the loaded coefficients")
        else:
            rig.instrument.firmware.send("freeze on")
            rig.load(export.coefficients, "swap to the exported coefficients")
        rig.restart_capture()
        rig.record()
        fresh = rig.captured_turn("fresh turn with the effect corrected")
        corrected = rig.rest_of_recording("fresh turn with the effect corrected")
        fresh_set = self.folder / "fresh"
        write_set(fresh_set, "a fresh turn", settings, [[fresh]], [])
        if case.lines:
            stage = "some turns forwards, and back"
            lines_counts |= self._lines("forwards", rig.recorded_turn(stage, turns=LINES_TURNS))
            rig.go_back(stage)
            back = rig.recorded_turn(stage, turns=LINES_TURNS, back=True)
            lines_counts |= self._lines("backwards", back)
        reversal = None
        if case.polygon:
            reversal = {
                "paper": self._polygon("the polygon again, paper's model", paper_bank),
                "corrected": self._polygon("the polygon again, exported", export.coefficients),
            }
        lines = settings.revolution.lines
        return HiddenResult(
            case=case,
            settings=settings,
            folder=measured,
            diagnosed=diagnosed,
            export=export,
            raw=score_turn(corrected.head1),
            paper=score_turn(paper.output),
            corrected=score_turn(corrected.output),
            unit_left_out=unit_left_out,
            raw_period=signal_period(corrected.head1, corrected.head1, lines),
            paper_period=signal_period(paper.output, paper.head1, lines),
            corrected_period=signal_period(corrected.output, corrected.head1, lines),
            fresh_capture_arcsec=left_on_fresh_set(diagnosed, fresh_set),
            firmware_orders=int(np.count_nonzero(paper_bank.amplitudes)),
            reversal_arcsec=reversal,
            lines_counts=lines_counts,
            clocks=rig.instrument.clock,
            simulating_s=time.monotonic() - started - workbench_s,
            workbench_s=workbench_s,
        )

    def _lines(self, name: str, recording: Recording) -> dict[str, list[float]]:
        """Return the amplitudes, in counts, that the case's lines have in the output."""
        if not self.case.lines:
            return {}
        seen = recording.output
        turns = seen.true_angle_rad / TURN_RAD
        orders = [*self.case.lines, *range(1, WHOLE_ORDERS + 1)]
        phase = TURN_RAD * np.multiply.outer(turns, orders)
        columns = np.hstack([np.ones((turns.size, 1)), np.cos(phase), np.sin(phase)])
        error = seen.position - turns * self.settings.revolution.counts_per_rev
        found = np.linalg.lstsq(columns, error, rcond=None)[0]
        cosine, sine = found[1:].reshape(2, -1)
        return {name: np.hypot(cosine, sine)[: len(self.case.lines)].tolist()}

    @property
    def _goes_on(self) -> bool:
        """Tell whether there is no further run, so that the judged turns continue the first run."""
        return not self.case.further

    def _diagnosed(self, measured: Path) -> tuple[DiagnosedModel, Export]:
        """Return the workbench's result, and the coefficients at the temperature of the judged
        turns."""
        effects_folder = self.folder / "effects"
        # Remove the files of an earlier run, because the workbench never overwrites an effect file.
        for earlier in effects_folder.glob(f"{ADOPTED}*.py"):
            earlier.unlink()
        self.report_step("Workbench: gets the measurement set only")
        diagnosed = diagnose_and_add(
            measured,
            adopted_name=ADOPTED,
            effects_folder=effects_folder,
            effects_to_add=self.case.effects,
            added=self.case.added,
        )
        export = diagnosed.export(
            self.settings.revolution.lanes,
            self.case.fresh.temperature_c[0],
            conditions=self._conditions,
            with_local_table=self.case.local_table,
            with_real_orders=self.case.real_orders,
        )
        write_coefficient_file(self.folder / "coefficients.toml", export.coefficients)
        for words in diagnosed.words():
            self.report_step(f"  {words}")
        return diagnosed, export

    @property
    def _conditions(self) -> ConditionSettings | None:
        if not self.case.modulators:
            return None
        # The nominal speed must be below one count per clock, and this table already turns at
        # nearly one count per clock.
        scale = self.settings.revolution
        return ConditionSettings(
            nominal_deg_per_s=NOMINAL_SHARE * float(np.degrees(scale.speed_rad_s)),
            clock_hz=scale.clock_hz,
        )

    def _drive(self, plan: RunPlan, turns: float) -> Motion:
        scale = self.settings.revolution
        drive = turning(
            plan.side * plan.speed * scale.speed_rad_s,
            turns + FURTHER_TURNS,
            ripple_rad=scale.ripple_rad,
            ripple_order=scale.ripple_order,
            temperature_c=plan.temperature_c,
            start_s=plan.start_s,
        )
        if plan.second_speed is None:
            return drive
        return with_second_speed(drive, plan.second_speed * scale.speed_rad_s)

    @property
    def _first_turns(self) -> float:
        if self.case.lines:
            return 13.0 + self.case.reference_turns
        if self.case.real_orders:
            return 8.0
        return 4.6 if self._goes_on else 2.0

    def _first_run(self) -> Coefficients:
        """Capture two turns upwards at the usual temperature; if the reference takes several turns,
        read the reference before. Return the coefficients that the firmware calibrates from the
        first captured turn."""
        rig = self.rig
        drive = self._drive(RunPlan(), self._first_turns)
        several = self.case.reference_turns > 1
        rig.power_up(
            and_back(drive, TURNS_BACK) if self.case.lines else drive,
            frozen=several,
            stage="over both indices",
        )
        if several:
            # Read the reference before the first calibration, while the output equals the reading
            # of head 1.
            rig.record(self.case.reference_turns)
            for _ in range(self.case.reference_turns):
                rig.captured_turn("turns of the reference")
            readings = rig.rest_of_recording("turns of the reference", self.case.reference_turns)
            self._reference_of(readings, rig.present_drive)
            rig.restart_capture()
            rig.instrument.firmware.send("freeze off")
        rig.record()
        first = rig.captured_turn("first turn: captured, not corrected")
        if several:
            rig.rest_of_recording("first turn")
        elif not self.case.polygon:
            self._reference_of(rig.rest_of_recording("first turn"), rig.present_drive)
        firmware = rig.instrument.firmware
        reported = firmware.telemetry[-1]
        if reported["result"] != "applied":
            raise InstrumentError(
                f"the firmware did not apply the first turn: {reported['result']}, "
                f"{reported['reason']}"
            )
        firmware.send("freeze on")
        rig.settle("calibration, swap and ramp")
        bank = firmware.coefficients
        assert bank is not None
        rig.record()
        second = rig.captured_turn("second turn: the paper's model")
        self.runs.append([first, second])
        rig.rest_of_recording("second turn: the paper's model")
        return bank

    def _further_run(self, plan: RunPlan, number: int) -> None:
        rig = self.rig
        rig.power_up(self._drive(plan, plan.turns), frozen=True, stage=f"run {number}: indices")
        if plan.reference:
            rig.record()
        turns = [rig.captured_turn(f"run {number}") for _ in range(plan.turns)]
        self.runs.append(turns)
        if plan.reference:
            self._reference_of(rig.instrument.recording(), rig.present_drive)

    def _fresh_power_up(self) -> None:
        several = self.case.modulators or self.case.local_table
        drive = self._drive(self.case.fresh, 6.0 if several else 4.0)
        self.rig.power_up(drive, frozen=True, stage="fresh: over both indices")

    def _reference_of(self, recording: Recording, drive: Motion) -> None:
        readings = on_the_move(recording, drive, self.settings.stations, self.case.reference_turns)
        self.references.append(
            self._rows(readings, drive, f"rotary reference, {self.settings.stations} marks", None)
        )

    def _rows(
        self, readings: Readings, drive: Motion, instrument: str, faces: int | None
    ) -> Reference:
        return as_reference(
            readings,
            drive,
            counts_per_rev=self.settings.revolution.counts_per_rev,
            noise_arcsec=self.settings.reference_noise_arcsec,
            random=self.random,
            instrument=instrument,
            faces=faces,
            run=len(self.references),
        )

    def _polygon(self, stage: str, bank: Coefficients | None) -> float:
        """Move up and down over the faces; return mean error upwards minus downwards, arcseconds.

        If ``bank`` is None, the output equals the reading of head 1, and the measured rows become
        part of the measurement set.
        """
        rig, settings = self.rig, self.settings
        clock_hz = rig.instrument.clock_hz
        plan = over_stations(
            settings.revolution.speed_rad_s,
            settings.faces,
            settings.cycles,
            stop_s=STOP_CLOCKS / clock_hz,
            start_s=5400.0,
        )
        rig.power_up(plan.drive, frozen=True, stage=f"{stage}: indices")
        if bank is not None:
            rig.load(bank, stage)
        rig.instrument.record(every=1)
        rig.work_until_the_end(stage)
        recording = rig.instrument.recording()
        counts = counts_standing(recording.output, rig.clock_of(plan.station_s))
        # With a bank the zero belongs to the corrected output; the zero cancels, because only
        # differences are used here.
        zero = 0 if bank is not None else zero_level(recording)
        readings = Readings(
            plan.station_s,
            plan.target_deg,
            plan.direction,
            plan.cycle,
            counts - zero,
            plan.drive.state(plan.station_s).angle_rad,
        )
        rows = self._rows(
            readings, plan.drive, f"{settings.faces}-sided polygon, autocollimator", settings.faces
        )
        if bank is None:
            self.references.append(rows)
        up = rows.error_arcsec[plan.direction > 0].mean()
        return float(up - rows.error_arcsec[plan.direction < 0].mean())
