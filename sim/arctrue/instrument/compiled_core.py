"""Runs the compiled core and its clock, with a table, curves or pin levels at the heads."""

from __future__ import annotations

import math
import time
from typing import Any, Literal

import numpy as np

from arctrue.instrument.curve_feeder import CurveFeeder
from arctrue.instrument.curves import Curves, TableCurves
from arctrue.instrument.errors import InstrumentError
from arctrue.instrument.library import Disturbance
from arctrue.instrument.pins import PinFault
from arctrue.instrument.run_progress import ReportRun, RunProgress
from arctrue.table import Motion, PinEvents, RotaryTable

RESET_CLOCKS = 80
"""Length of a reset in clocks; arctrue_core requires at least 64."""
_SLICE_CLOCKS = 100_000
_UNLIMITED_CLOCKS = 1 << 50

Reason = Literal["clocks", "true_angle", "interrupt", "end"]
_REASONS: tuple[Reason, ...] = ("clocks", "true_angle", "interrupt", "end")


class CompiledCore:
    """The core as a compiled netlist: its time, and the stimulus of its heads.

    ``clock_hz``: clocks of the gateware per second of table time.
    """

    def __init__(
        self,
        library: Any,
        clock_hz: float,
        report_run: ReportRun | None,
        progress_every_s: float,
    ) -> None:
        """Create a core in the loaded ``library``; the core is not yet reset.

        ``report_run`` receives the progress of a run every ``progress_every_s`` seconds.
        """
        self.library = library
        self.clock_hz = clock_hz
        self._progress, self._progress_every_s = report_run, progress_every_s
        self._reported = (time.monotonic(), 0)
        self._begin = 0
        self._feeder: CurveFeeder | None = None
        self._end: int | None = None
        self.handle = self.library.instrument_new()

    def close(self) -> None:
        """Free the instrument's memory, after which the instrument cannot be used."""
        if self._feeder is not None:
            self._feeder.close()
            self._feeder = None
        if self.handle:
            self.library.instrument_delete(self.handle)
            self.handle = None

    @property
    def clock(self) -> int:
        """Number of clocks since power-on."""
        return int(self.library.instrument_clock(self.handle))

    @property
    def time_s(self) -> float:
        """Seconds of the table's time that have passed since power-on."""
        return self.clock / self.clock_hz

    @property
    def message(self) -> str:
        """Latest message of the harness."""
        return str(self.library.instrument_message(self.handle).decode())

    def reset(self, clocks: int = RESET_CLOCKS) -> None:
        """Hold the core in reset while the bus is idle; the coefficient banks keep their content.

        Parameters
        ----------
        clocks : int
            Length of the reset.
        """
        self.library.instrument_hold_reset(self.handle, 1)
        self.run(clocks)
        self.library.instrument_hold_reset(self.handle, 0)
        self.run(5)

    def run(self, clocks: int, *, stage: str = "") -> None:
        """Run the core for ``clocks`` clocks.

        Parameters
        ----------
        clocks : int
            Number of clocks.
        stage : str
            Name of this part of the run, for ``report_run``.
        """
        self._run(clocks, stage=stage)

    def run_until(
        self,
        *,
        true_angle_rad: float | None = None,
        interrupt: bool = False,
        end_of_stimulus: bool = False,
        at_most_clocks: int | None = None,
        stage: str = "",
    ) -> Reason:
        """Run the core until the first of these conditions is met.

        Parameters
        ----------
        true_angle_rad : float, optional
            True angle, not wrapped, radians; passing it in either direction ends the run. It needs
            a table or curves.
        interrupt : bool
            True: a high level of the interrupt line ends the run.
        end_of_stimulus : bool
            True: the end of the stimulus ends the run; without ``at_most_clocks`` it always does.
        at_most_clocks : int, optional
            Number of clocks after which the run ends.
        stage : str
            Name of this part of the run, for ``report_run``.

        Returns
        -------
        str
            The condition: ``clocks``, ``true_angle``, ``interrupt`` or ``end``.

        Raises
        ------
        InstrumentError
            If there is neither a stimulus nor ``at_most_clocks``, or the harness reports a fault.
        """
        if at_most_clocks is None and self._end is None:
            raise InstrumentError(
                "run_until() without a stimulus would run for ever: attach a table, "
                "or give at_most_clocks"
            )
        most = _UNLIMITED_CLOCKS if at_most_clocks is None else at_most_clocks
        ends = end_of_stimulus or at_most_clocks is None
        return self._run(most, true_angle_rad, interrupt, ends, stage)

    def _run(
        self,
        clocks: int,
        true_angle_rad: float | None = None,
        interrupt: bool = False,
        end: bool = False,
        stage: str = "",
    ) -> Reason:
        angle = math.nan if true_angle_rad is None else true_angle_rad
        last = self.clock + clocks
        while (left := last - self.clock) > 0:
            code = int(
                self.library.instrument_run(
                    self.handle, min(left, _SLICE_CLOCKS), angle, interrupt, end
                )
            )
            if code < 0:
                self._fail()
            self._report(stage)
            if code:
                return _REASONS[code]
        return "clocks"

    def _fail(self) -> None:
        if self._feeder is not None and self._feeder.error is not None:
            error, self._feeder.error = self._feeder.error, None
            raise error
        raise InstrumentError(self.message)

    def _report(self, stage: str) -> None:
        if self._progress is None:
            return
        now, (then, clock) = time.monotonic(), self._reported
        if now - then >= self._progress_every_s:
            rate = (self.clock - clock) / (now - then)
            self._reported = (now, self.clock)
            share, left_s = math.nan, math.nan
            if self._end is not None and self._end > self._begin:
                share = min((self.clock - self._begin) / (self._end - self._begin), 1.0)
                left_s = max(self._end - self.clock, 0) / rate if rate else math.nan
            self._progress(RunProgress(stage, self.clock, rate, self.true_angle_rad, share, left_s))

    def attach(
        self,
        table: RotaryTable,
        motion: Motion,
        *,
        knot_clocks: int | None = None,
        may_jump: bool = False,
    ) -> None:
        """Connect a table to the heads; its motion begins at the present clock.

        In every clock each pin has the level of the head's present count. In the first clock A and
        B may change together, which is an illegal transition. ``reset()`` and ``firmware.start()``
        clear this fault, so call this method before them; a real table is also connected before
        power-on.

        Parameters
        ----------
        table : RotaryTable
            The table.
        motion : Motion
            Motion of the table; after its end the pins hold their levels.
        knot_clocks : int, optional
            Clocks between two knots of the readings; None: a power of two, up to 4096, in which the
            table travels at most 16 counts.
        may_jump : bool
            Permit more than one count of a head in one clock; without it, such a step ends the run
            with InstrumentError.

        Raises
        ------
        UnhonouredCauseError
            If a cause of the table's error acts on a quantity other than the lines and their
            signals.
        InstrumentError
            If the motion is shorter than a clock.
        """
        curves = TableCurves(table, motion, self.clock_hz, knot_clocks)
        self.attach_curves(curves, may_jump=may_jump)

    def attach_curves(self, curves: Curves, *, may_jump: bool = False) -> None:
        """Connect arbitrary readings to the heads; the readings begin at the present clock.

        Parameters
        ----------
        curves : Curves
            The readings.
        may_jump : bool
            Permit more than one count of a head in one clock; without it, such a step ends the run
            with InstrumentError.
        """
        self.detach()
        self._feeder = CurveFeeder(self.library, self.handle, self.clock, curves)
        self._begin, self._end = self.clock, self.clock + curves.clocks
        self.library.instrument_attach_curves(
            self.handle,
            self._feeder.callback,
            None,
            self._end,
            curves.counts_per_rev,
            curves.index_width_counts,
            curves.rounding_counts,
            may_jump,
        )

    def attach_pins(self, events: PinEvents) -> None:
        """Apply the levels of ``events`` to A, B and Z of two heads; head 1 has the low bits.

        Parameters
        ----------
        events : PinEvents
            The events; their clock 0 is the present clock.
        """
        self.detach()
        clock = np.ascontiguousarray(events.clock + self.clock, dtype=np.int64)
        levels = np.ascontiguousarray(events.levels, dtype=np.uint8)
        self._begin, self._end = self.clock, int(clock[-1]) + 1 if clock.size else self.clock
        self.library.instrument_attach_events(
            self.handle, clock.size, clock.ctypes.data, levels.ctypes.data, events.first_levels
        )

    def detach(self) -> None:
        """Disconnect the stimulus; the pins keep their last levels."""
        self.library.instrument_detach(self.handle)
        if self._feeder is not None:
            self._feeder.close()
            self._feeder = None
        self._end = None

    @property
    def ended(self) -> bool:
        """True after the end of the stimulus."""
        return self._end is not None and self.clock >= self._end

    @property
    def true_angle_rad(self) -> float:
        """True angle of the table at the present clock, not wrapped; NaN without a table, and
        before its motion has begun."""
        return float(self.library.instrument_true_angle(self.handle))

    def disturb(self, *faults: PinFault, seed: int = 1) -> None:
        """Apply faults to the pins of the heads; earlier faults end.

        Parameters
        ----------
        *faults : PinFault
            Faults, which act in this order; without any, all earlier faults are removed.
        seed : int
            Seed of the random numbers.
        """
        made = (Disturbance * max(1, len(faults)))(
            *(
                Disturbance(f.first_clock, f.clocks, f.invert, f.low, f.high, f.probability)
                for f in faults
            )
        )
        self.library.instrument_disturb(self.handle, len(faults), made, seed)
