"""Combines a table and an instrument: powers the instrument up, drives the table, and reads turn by
turn."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.device.load import load_frames
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.local_table import LocalTable
from arctrue.gateware.table_conditions import slew_word
from arctrue.generated.number_formats import CLOCK_HZ
from arctrue.instrument import PROBE_IN, Instrument, InstrumentError, PinFault, Recording
from arctrue.instrument.turn_score import BINS
from arctrue.studies.hidden_effect.cases import DriveIndex
from arctrue.studies.hidden_effect.drive import TURN_RAD, times_at
from arctrue.studies.hidden_effect.settings import HiddenSettings
from arctrue.studies.revolution import set_up
from arctrue.table import Motion, RotaryTable

SPARE_TURNS = 0.06
"""Length, in turns, by which a recording exceeds its whole turns, so that it contains an index and
a station at its end."""

FROM_A_WRAP_TURNS = 0.02
"""Distance from angle 0, in turns, beyond which reading and true angle have the same turn number;
it is far larger than the error of the reading."""

_ENABLE_CLOCKS = 200
PULSE_CLOCKS = 100
TURNS_FOR_THE_PHASE = 4
"""Largest number of turns to wait for an index of the drive; the index of a belt comes once in two
turns."""
LEAD_IN_CLOCKS = 20_000
"""Number of clocks over which the correction of a condition fades in when the direction becomes
known: a fifteenth of a turn at 2¹⁸ counts."""


@dataclass(frozen=True, slots=True)
class CapturedTurn:
    """Samples of one bank that the gateware filled; arrays ``(n,)``."""

    time_s: NDArray[np.float64]
    """Time of each sample since the start of the measurement."""
    head1_counts: NDArray[np.int64]
    head2_counts: NDArray[np.int64]
    temperature_c: NDArray[np.float64]


class Rig:
    """Table and instrument of an experiment; the instrument can be powered up any number of
    times."""

    def __init__(
        self, instrument: Instrument, table: RotaryTable, settings: HiddenSettings
    ) -> None:
        """Store the parts; the table is not yet attached to the heads."""
        self.instrument = instrument
        self.table = table
        self.settings = settings
        self.drive: Motion | None = None
        self._attached_clock = 0
        self._timestamp_offset = 0

    @property
    def present_drive(self) -> Motion:
        """Return the present drive of the table. Raises InstrumentError before the first
        power-up."""
        if self.drive is None:
            raise InstrumentError("the table is not driven yet: call power_up() first")
        return self.drive

    def power_up(self, drive: Motion, *, frozen: bool, stage: str) -> None:
        """Put the table at the start of ``drive``, reset the instrument, start the firmware, and
        run until the table has passed both indices.

        With ``frozen`` the firmware judges each turn but does not change the coefficients.
        """
        self.drive = drive
        self._attached_clock = self.instrument.clock
        self.instrument.attach(self.table, drive)
        self.instrument.reset()
        firmware = self.instrument.firmware
        set_up(firmware, self.settings.revolution)
        firmware.send(f"freeze {'on' if frozen else 'off'}")
        self._timestamp_offset = self.instrument.clock - self.instrument.snapshot().time
        firmware.run(
            until=lambda f: f.phase == "capture",
            poll_clocks=self.settings.revolution.poll_clocks,
            stage=stage,
        )

    def motion_time_s(self, clock: NDArray[np.float64]) -> NDArray[np.float64]:
        """Convert clocks of the instrument to instants of the present motion."""
        return np.asarray((clock - self._attached_clock) / self.instrument.clock_hz)

    def record(self, turns: int = 1) -> None:
        """Start a recording that is slightly longer than ``turns`` turns."""
        self.instrument.record(bins=BINS, every=self.settings.kept_every, turns=turns + SPARE_TURNS)

    def captured_turn(self, stage: str) -> CapturedTurn:
        """Run until the gateware has filled a bank, read the bank, and then let the firmware
        process it."""
        instrument, poll = self.instrument, self.settings.revolution.poll_clocks
        while not instrument.read("status.capture_ready"):
            self._pass(poll, stage)
        bank = instrument.read_capture()
        self.work(stage)
        size = bank.samples.shape[0]
        period = self.settings.revolution.sample_period_clocks
        start = bank.start_time + self._timestamp_offset
        moving_s = self.motion_time_s(start + period * np.arange(size, dtype=np.float64))
        drive = self.present_drive
        counts = bank.samples.astype(np.int64)
        return CapturedTurn(
            drive.start_s + moving_s, counts[:, 0], counts[:, 1], drive.temperature_c(moving_s)
        )

    def work(self, stage: str) -> None:
        """Run the firmware until it has read the full bank, has calibrated, and has swapped the
        banks if it decides to do so."""
        reported = len(self.instrument.firmware.telemetry)
        self.instrument.firmware.run(
            until=lambda f: len(f.telemetry) > reported and f.phase == "capture",
            poll_clocks=self.settings.revolution.poll_clocks,
            stage=stage,
        )

    def settle(self, stage: str) -> None:
        """Run until a swapped bank is active and its ramp has ended."""
        instrument = self.instrument
        while True:
            status = instrument.read_fields("status")
            if status["compensating"] and not status["ramp_busy"]:
                return
            self._pass(self.settings.revolution.poll_clocks, stage)

    def load(self, coefficients: Coefficients, stage: str) -> None:
        """Write a whole bank with all its lanes and make it active.

        The caller must have set ``freeze``: otherwise the firmware would write its own bank, which
        contains only integer orders.
        """
        instrument = self.instrument
        swaps = instrument.read("swap_count")
        if coefficients.extension is not None and coefficients.extension.conditions is not None:
            instrument.write_conditions(
                coefficients.extension.conditions, coefficients.counts_per_rev
            )
            slew = slew_word(LEAD_IN_CLOCKS / CLOCK_HZ)
            instrument.write("conditions.slew", slew)
        instrument.write_coefficients(coefficients)
        if coefficients.extension is not None and coefficients.extension.local_table is not None:
            table = LocalTable.of_file(
                coefficients.extension.local_table, coefficients.counts_per_rev
            )
            instrument.write_local_table(table)
        instrument.command("swap")
        while instrument.read("swap_count") == swaps:
            self._pass(self.settings.revolution.poll_clocks, stage)
        instrument.update("control", compensate=1)
        # The status shows the ramp only after the pipeline has received the enable.
        self._pass(_ENABLE_CLOCKS, stage)
        self.settle(stage)

    def give_index_of_drive(self, index: DriveIndex) -> None:
        """Put a pulse on ``probe_in`` at every later index of the drive in the present motion."""
        drive = self.present_drive
        passed_rad = drive.state(np.linspace(0.0, drive.duration_s, 1000)).angle_rad
        numbers = (passed_rad / TURN_RAD - index.first_turns) * index.per_turn
        number = np.arange(math.floor(numbers.min()), math.ceil(numbers.max()) + 1)
        places_rad = TURN_RAD * (index.first_turns + number / index.per_turn)
        clocks = np.rint(self.clock_of(times_at(drive, places_rad))).astype(np.int64)
        later = clocks[clocks > self.instrument.clock].tolist()
        self.instrument.disturb(*(PinFault(clock, PULSE_CLOCKS, high=PROBE_IN) for clock in later))

    def load_with_index_of_drive(self, coefficients: Coefficients, stage: str) -> None:
        """Load the coefficients over the console, and run turns until the firmware has the phase of
        each lane.

        Raises InstrumentError if this takes more than TURNS_FOR_THE_PHASE turns.
        """
        self.load_over_console(coefficients, stage)
        firmware = self.instrument.firmware
        for _ in range(TURNS_FOR_THE_PHASE):
            if "phase_unknown" not in firmware.send("load status"):
                self.settle(stage)
                return
            self.recorded_turn(stage)
        raise InstrumentError("no index of the drive gave the firmware a phase")

    def go_back(self, stage: str) -> None:
        """Run until the table turns in the opposite direction at its full speed."""
        drive = self.present_drive
        clock = float(self.clock_of(np.array(drive.knot_times_s[-3])))
        self.instrument.firmware.run(
            until=lambda _: self.instrument.clock >= clock,
            poll_clocks=self.settings.revolution.poll_clocks,
            stage=stage,
        )

    def load_over_console(self, coefficients: Coefficients, stage: str) -> None:
        """Send the coefficients in the frames of ``arctrue load --force``, and run the turn that
        tests them.

        The calibration continues. The load is forced because small orders cannot be tested while
        the table warms within the turn; the firmware then tests only the other orders. Raises
        InstrumentError if the firmware refuses the frames.
        """
        firmware = self.instrument.firmware
        for frame in load_frames(coefficients, force=True):
            answer = firmware.send(frame)
            if answer != "ok":
                raise InstrumentError(f"the firmware refuses {frame!r}: {answer}")
        self.captured_turn(stage)
        state = firmware.send("load status").splitlines()[0]
        if state != "load active":
            raise InstrumentError(f"the captured turn does not confirm the loaded file: {state}")
        self.settle(stage)

    def first_turn_number(self) -> int:
        """Return the core's number for the turn that begins at the true angle 0 of the table."""
        turns = self.instrument.true_angle_rad / TURN_RAD
        if abs(turns - round(turns)) < FROM_A_WRAP_TURNS:
            self.instrument.run(
                int(FROM_A_WRAP_TURNS * self._clocks_a_turn()), stage="off the zero"
            )
            turns = self.instrument.true_angle_rad / TURN_RAD
        return self.instrument.read("turn_number") - math.floor(turns)

    def _clocks_a_turn(self) -> float:
        drive = self.present_drive
        return TURN_RAD / abs(drive.knot_speeds_rad_s[1]) * self.instrument.clock_hz

    def restart_capture(self) -> None:
        """Discard the samples of the present turn: the next capture begins now."""
        self.instrument.update("control", capture_enable=0)
        self.instrument.update("control", capture_enable=1)

    def rest_of_recording(self, stage: str, turns: int = 1) -> Recording:
        """Run until the recording contains all its turns; the recording ends by itself."""
        drive = self.present_drive
        side = float(np.sign(drive.knot_speeds_rad_s[1]))
        instrument = self.instrument
        first = instrument.recording().output.true_angle_rad[0]
        end = first + side * TURN_RAD * (turns + SPARE_TURNS)
        while side * (instrument.true_angle_rad - end) < 0:
            self._pass(self.settings.revolution.poll_clocks, stage)
        return instrument.recording()

    def work_until_the_end(self, stage: str) -> None:
        """Run the firmware's main loop until the motion is over."""
        self.instrument.firmware.run(
            until=lambda _: self.instrument.ended,
            poll_clocks=self.settings.revolution.poll_clocks,
            stage=stage,
        )

    def clock_of(self, motion_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Convert instants of the present motion to clocks of the instrument."""
        return np.asarray(self._attached_clock + motion_s * self.instrument.clock_hz)

    def recorded_turn(self, stage: str, *, turns: int = 1, back: bool = False) -> Recording:
        """Record one or more turns from now on, while the firmware continues to work.

        ``back``: the table now turns against the direction in which its motion began.
        """
        self.record(turns)
        self.instrument.run(self.settings.revolution.poll_clocks, stage=stage)
        drive = self.present_drive
        side = float(np.sign(drive.knot_speeds_rad_s[1])) * (-1.0 if back else 1.0)
        end = self.instrument.true_angle_rad + side * TURN_RAD * (turns + SPARE_TURNS)
        self.instrument.firmware.run(
            until=lambda _: side * (self.instrument.true_angle_rad - end) >= 0,
            poll_clocks=self.settings.revolution.poll_clocks,
            stage=stage,
        )
        return self.instrument.recording()

    def _pass(self, clocks: int, stage: str) -> None:
        if self.instrument.ended:
            raise InstrumentError(f"the motion ended during: {stage}")
        self.instrument.run(clocks, stage=stage)
