"""Connects the compiled core to a table at its inputs and to the processor's bus."""

from __future__ import annotations

import ctypes
import math
import time
from collections.abc import Callable, Coroutine, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Literal, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from arctrue.base.printable import time_left
from arctrue.base.progress import ReportStep
from arctrue.gateware.extension import Conditions
from arctrue.gateware.local_table import LocalTable
from arctrue.gateware.register_access import CaptureBank, CoefficientSet, RegisterMap, Snapshot
from arctrue.generated.number_formats import CAPTURE_DEPTH_DEFAULT, CLOCK_HZ, LANES_DEFAULT
from arctrue.instrument.build import build
from arctrue.instrument.curves import Curve, Curves, TableCurves
from arctrue.instrument.errors import BusError, InstrumentError
from arctrue.instrument.firmware import Firmware
from arctrue.instrument.library import NEED_PIECE, Disturbance, TrackView, load
from arctrue.instrument.recording import EdgeTrack, Recording
from arctrue.table import Motion, PinEvents, RotaryTable

HEAD1_A, HEAD1_B, HEAD1_Z, HEAD2_A, HEAD2_B, HEAD2_Z = (1 << pin for pin in range(6))
SYNC_IN, PROBE_IN = (1 << pin for pin in range(6, 8))
HEAD3_A, HEAD3_B, HEAD3_Z, HEAD4_A, HEAD4_B, HEAD4_Z = (1 << pin for pin in range(8, 14))
TRIGGER_OUT, COMPARE_OUT = (1 << place for place in range(9, 11))
"""Masks of trigger_out and compare_out in the levels that :meth:`Instrument.traced` returns."""

RESET_CLOCKS = 80
"""Length of a reset in clocks; arctrue_core requires at least 64."""
_PIECE_CLOCKS = 1 << 18
_SLICE_CLOCKS = 100_000
_UNLIMITED_CLOCKS = 1 << 50
_LATENCY_EDGES = 48
_LATENCY_SPACING_CLOCKS = 9

Reason = Literal["clocks", "true_angle", "interrupt", "end"]
_REASONS: tuple[Reason, ...] = ("clocks", "true_angle", "interrupt", "end")
_T = TypeVar("_T")


@dataclass(frozen=True, slots=True)
class RunProgress:
    """Progress of a run: clocks, true angle of the table, and remaining time."""

    stage: str
    """Name of the part of the run that is in progress."""
    clock: int
    """Number of clocks since power-on."""
    clocks_per_s: float
    """Simulated clocks per second of wall time since the previous report."""
    true_angle_rad: float
    """True angle of the table; NaN without a table."""
    share: float = math.nan
    """Fraction of the present motion that is completed; NaN without a motion."""
    seconds_left: float = math.nan
    """Remaining wall time in seconds until the present motion ends, at the present speed of the
    run."""

    @property
    def words(self) -> str:
        """Return the progress as one line of text for the user."""
        table = ""
        if math.isfinite(self.true_angle_rad):
            table = f"table at {self.true_angle_rad / (2 * math.pi):.2f} turns, "
        share = ""
        if math.isfinite(self.share):
            left = time_left(self.seconds_left)
            share = f"{100.0 * self.share:.0f} % of this motion, {left} left; "
        return (
            f"{self.stage}: {share}{table}{self.clock / 1e6:,.1f} million clocks, "
            f"{self.clocks_per_s / 1e3:,.0f} thousand a second"
        )


ReportRun = Callable[[RunProgress], None]
"""Type of the function that receives the progress of a run every few seconds."""


@dataclass(frozen=True, slots=True)
class PinFault:
    """Fault on the wires between heads and core, which begins at ``first_clock``.

    ``invert``, ``low`` and ``high`` are sums of HEAD1_A … HEAD4_Z: pins that are inverted or held.
    With ``probability`` below 1 the fault acts only in clocks that are drawn at random. Without a
    fault, SYNC_IN and PROBE_IN are low; ``high`` puts a pulse on them.
    """

    first_clock: int
    """Clock at which the fault begins."""
    clocks: int
    """Length of the fault in clocks."""
    invert: int = 0
    """Pins that are inverted."""
    low: int = 0
    """Pins that are held low."""
    high: int = 0
    """Pins that are held high."""
    probability: float = 1.0
    """Probability that the fault acts, in each clock."""


def clock_hz_for(counts_per_rev: int, speed_rad_s: float, clocks_per_count: float = 1.1) -> float:
    """Return the clock frequency at which a count lasts ``clocks_per_count`` clocks.

    Parameters
    ----------
    counts_per_rev : int
        Counts a turn.
    speed_rad_s : float
        Speed of the table, radians a second.
    clocks_per_count : float
        Number of clocks that a count lasts.

    Returns
    -------
    float
        Clocks of the gateware per second of table time.
    """
    return abs(speed_rad_s) / (2 * math.pi) * counts_per_rev * clocks_per_count


def _now(coroutine: Coroutine[Any, Any, _T]) -> _T:
    """Return the result of a coroutine that never waits; over this bus, RegisterMap never waits."""
    try:
        coroutine.send(None)
    except StopIteration as done:
        result: _T = done.value
        return result
    raise AssertionError("an access to the compiled core never waits")


class _Feeder:
    """Passes curves to the harness piece by piece, and computes the next piece while the harness
    runs."""

    def __init__(self, instrument: Instrument, curves: Curves) -> None:
        self._instrument = instrument
        self._curves = curves
        self._start = instrument.clock
        self._pool = ThreadPoolExecutor(1)
        self._next: tuple[int, Future[tuple[int, *tuple[Curve, ...]]]] | None = None
        self.error: BaseException | None = None
        self.callback = NEED_PIECE(self._hand_over)

    def close(self) -> None:
        self._pool.shutdown(wait=True, cancel_futures=True)

    def _hand_over(self, _: int | None, clock: int) -> int:
        try:
            first = clock - self._start
            if self._next is not None and self._next[0] == first:
                knot, *values = self._next[1].result()
            else:
                knot, *values = self._curves.piece(first, _PIECE_CLOCKS)
            rows = np.ascontiguousarray(values, dtype=np.float64)
            heads, knots = rows.shape[0] - 1, rows.shape[1]
            self._instrument.library.instrument_piece(
                self._instrument.handle, clock, knot, knots, heads, rows.ctypes.data
            )
            following = first + knot * (knots - 3)
            self._next = None
            if following < self._curves.clocks:
                future = self._pool.submit(self._curves.piece, following, _PIECE_CLOCKS)
                self._next = (following, future)
        except Exception as error:
            self.error = error
            return 1
        return 0


class Instrument:
    """One virtual instrument, used as a context manager; its library is built on first use.

    ``clock_hz``: clocks of the gateware per second of table time. A value below the real 100 MHz
    needs fewer clocks for the same motion of the table, see :func:`clock_hz_for`.
    """

    def __init__(
        self,
        lanes: int = LANES_DEFAULT,
        capture_depth: int = CAPTURE_DEPTH_DEFAULT,
        *,
        clock_hz: float = float(CLOCK_HZ),
        generics: Mapping[str, int | str] | None = None,
        report_run: ReportRun | None = None,
        progress_every_s: float = 5.0,
        report_step: ReportStep | None = None,
    ) -> None:
        """Build and load the library of the instrument. ``generics``: further generics of
        arctrue_core.

        Raises InstrumentError.
        """
        self.library = load(build(lanes, capture_depth, generics=generics, report_step=report_step))
        self.clock_hz = clock_hz
        self._progress, self._progress_every_s = report_run, progress_every_s
        self._reported = (time.monotonic(), 0)
        self._begin = 0
        self._feeder: _Feeder | None = None
        self._end: int | None = None
        self._recorded_counts_per_rev = 0
        self._firmware: Firmware | None = None
        self.registers = RegisterMap(self._read_async, self._write_async)
        """Registers by name, with asynchronous methods; this class has the same methods in a
        synchronous form."""
        self.handle = self.library.instrument_new()
        self._bare_latency_clocks = self._measure_latency()
        self.library.instrument_delete(self.handle)
        self.handle = self.library.instrument_new()
        self.reset()

    def __enter__(self) -> Self:
        """Return the instrument itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the instrument."""
        self.close()

    def close(self) -> None:
        """Free the instrument's memory, after which the instrument cannot be used."""
        if self._feeder is not None:
            self._feeder.close()
            self._feeder = None
        if self._firmware is not None:
            self._firmware.close()
            self._firmware = None
        if self.handle:
            self.library.instrument_delete(self.handle)
            self.handle = None

    # Time ---------------------------------------------------------------------------------

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

    # Stimulus of the heads ---------------------------------------------------------------------

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
            Permit two counts of a head in one clock, which otherwise end the run with
            InstrumentError.

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
            Permit two counts of a head in one clock, which otherwise end the run with
            InstrumentError.
        """
        self.detach()
        self._feeder = _Feeder(self, curves)
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

    # Access by the processor ---------------------------------------------------------------------

    @property
    def firmware(self) -> Firmware:
        """The firmware that acts as the processor; it is created at the first use."""
        if self._firmware is None:
            self._firmware = Firmware(self)
        return self._firmware

    @property
    def interrupt(self) -> bool:
        """Level of the interrupt line."""
        return bool(self.library.instrument_interrupt(self.handle))

    def stall_bus(self, most_clocks: int, seed: int = 1) -> None:
        """Delay all channels of the bus by random times.

        Parameters
        ----------
        most_clocks : int
            Largest delay; each delay lasts 0 … ``most_clocks`` clocks.
        seed : int
            Seed of the random numbers.
        """
        self.library.instrument_stall(self.handle, most_clocks, seed)

    def read_words(self, address: int, count: int) -> list[int]:
        """Read words of 32 bits from the bus.

        Parameters
        ----------
        address : int
            Byte address of the first word.
        count : int
            Number of words.

        Returns
        -------
        list of int
            The words.

        Raises
        ------
        BusError
            If the core refuses the access.
        """
        words: NDArray[np.uint32] = np.zeros(count, dtype=np.uint32)
        failed = ctypes.c_uint32()
        response = self.library.instrument_read(
            self.handle, address, words.ctypes.data, count, ctypes.byref(failed)
        )
        self._check(response, failed.value)
        values: list[int] = words.tolist()
        return values

    def write_words(self, address: int, words: Sequence[int]) -> None:
        """Write words of 32 bits to the bus.

        Parameters
        ----------
        address : int
            Byte address of the first word.
        words : sequence of int
            The words.

        Raises
        ------
        BusError
            If the core refuses the access.
        """
        data = np.array([word & 0xFFFF_FFFF for word in words], dtype=np.uint32)
        failed = ctypes.c_uint32()
        response = self.library.instrument_write(
            self.handle, address, data.ctypes.data, data.size, ctypes.byref(failed)
        )
        self._check(response, failed.value)

    def _check(self, response: int, address: int) -> None:
        if response < 0:
            self._fail()
        if response:
            raise BusError(address, response)

    async def _read_async(self, address: int, count: int) -> Sequence[int]:
        return self.read_words(address, count)

    async def _write_async(self, address: int, words: Sequence[int]) -> None:
        self.write_words(address, words)

    def read(self, path: str) -> int:
        """Return the value of a register with a single field, or of ``register.field``.

        Parameters
        ----------
        path : str
            Name of the register, or of register and field.

        Returns
        -------
        int
            The value.
        """
        return _now(self.registers.read(path))

    def read_fields(self, path: str) -> dict[str, int]:
        """Return the values of all fields of a register.

        Parameters
        ----------
        path : str
            Name of the register.

        Returns
        -------
        dict
            Values by the names of the fields.
        """
        return _now(self.registers.read_fields(path))

    def write(self, path: str, value: int) -> None:
        """Write a value to the only field of a register.

        Parameters
        ----------
        path : str
            Name of the register.
        value : int
            The value.
        """
        _now(self.registers.write(path, value))

    def update(self, path: str, **values: int) -> None:
        """Change some fields of a register and keep the other fields.

        Parameters
        ----------
        path : str
            Name of the register.
        **values : int
            Values by the names of the fields.
        """
        _now(self.registers.update(path, **values))

    def command(self, *names: str) -> None:
        """Set bits of the register ``command`` for one clock.

        Parameters
        ----------
        *names : str
            Names of the bits.
        """
        _now(self.registers.command(*names))

    def snapshot(self) -> Snapshot:
        """Return the positions of both heads and of the corrected output at one clock.

        Returns
        -------
        Snapshot
            The positions and the clock.
        """
        return _now(self.registers.snapshot())

    def read_capture(self) -> CaptureBank:
        """Return the capture bank that is ready; ``command("capture_release")`` releases it.

        Returns
        -------
        CaptureBank
            The samples of a turn.
        """
        return _now(self.registers.read_capture())

    def write_coefficients(self, coefficients: CoefficientSet) -> None:
        """Write all lanes to the idle coefficient bank; ``command("swap")`` makes it active.

        Parameters
        ----------
        coefficients : CoefficientSet
            The words of all lanes.
        """
        _now(self.registers.write_coefficients(coefficients))

    def write_conditions(self, conditions: Conditions, counts_per_rev: int) -> None:
        """Write the parameters of direction and speed to their idle bank.

        They are scaled to this instrument's clock; ``command("swap")`` makes this bank active.

        Parameters
        ----------
        conditions : Conditions
            The parameters.
        counts_per_rev : int
            Counts a turn.
        """
        _now(self.registers.write_conditions(conditions, counts_per_rev, self.clock_hz))

    def write_local_table(self, table: LocalTable) -> None:
        """Write a local table to its idle bank; ``command("swap")`` makes this bank active.

        Parameters
        ----------
        table : LocalTable
            The table.
        """
        _now(self.registers.write_local_table(table))

    # Access to the outputs of the core
    # ---------------------------------------------------------------------

    @property
    def latency_clocks(self) -> float:
        """Number of clocks from an edge of head 1's pins to the same edge at the uncorrected
        output.

        The instrument measures this delay on separate edges when it is created; the delay of the
        input filter is added.
        """
        return self._bare_latency_clocks + max(1, self.read("filter_length")) - 1

    def record(
        self, *, bins: int = 0, every: int = 0, most: int = 20_000_000, turns: float = 0.0
    ) -> None:
        """Begin to record edges; the recording replaces an earlier one.

        Parameters
        ----------
        bins : int
            Number of equal parts (bins) of a turn of true angle, each with statistics of all its
            edges; 0: no statistics.
        every : int
            Number N: every N-th edge is kept; 1: all edges, 0: none.
        most : int
            Largest number of kept edges.
        turns : float
            Number of turns of the table after which the recording ends exactly; 0:
            :meth:`stop_recording` ends it.
        """
        self._recorded_counts_per_rev = self.read("counts_per_rev_active")
        self.library.instrument_record(
            self.handle,
            bins,
            every,
            most,
            float(self._recorded_counts_per_rev),
            2 * math.pi * turns,
            self.latency_clocks,
        )

    def stop_recording(self) -> None:
        """End the recording; its data remain available."""
        self.library.instrument_stop_recording(self.handle)

    def recording(self) -> Recording:
        """Return the data recorded so far.

        Returns
        -------
        Recording
            The output and the incoming signal of head 1.

        Raises
        ------
        InstrumentError
            If :meth:`record` was not called.
        """
        if not self._recorded_counts_per_rev:
            raise InstrumentError("nothing was recorded: call record() first")
        output, view = self._track(0)
        head1, _ = self._track(1)
        return Recording(
            output,
            head1,
            int(view.illegal),
            _array(view.index_clock, view.indices, np.int64),
            _array(view.index_position, view.indices, np.int64),
        )

    def _track(self, which: int) -> tuple[EdgeTrack, TrackView]:
        view = TrackView()
        self.library.instrument_track(self.handle, which, ctypes.byref(view))
        edges = _array(view.bin_edges, view.bins, np.int64)
        with np.errstate(invalid="ignore"):
            mean = _array(view.bin_sum, view.bins, np.float64) / edges
        track = EdgeTrack(
            counts_per_rev=self._recorded_counts_per_rev,
            clock=_array(view.kept_clock, view.kept, np.int64),
            position=_array(view.kept_position, view.kept, np.int64),
            true_angle_rad=_array(view.kept_angle, view.kept, np.float64),
            bin_edges=edges,
            bin_mean_counts=mean,
            bin_lowest_counts=_array(view.bin_lowest, view.bins, np.float64),
            bin_highest_counts=_array(view.bin_highest, view.bins, np.float64),
            edges=int(view.edges),
            dropped=int(view.dropped),
        )
        return track, view

    def trace(self, clocks: int) -> None:
        """Begin to record the levels of heads 1 and 2 and of the outputs in every clock.

        Parameters
        ----------
        clocks : int
            Number of clocks to record.
        """
        self.library.instrument_trace(self.handle, clocks)

    def traced(self) -> NDArray[np.uint16]:
        """Return the recorded levels of the pins.

        Returns
        -------
        ndarray
            One word per clock, shape (n,): the six pins of heads 1 and 2, above them A, B and Z of
            the output, TRIGGER_OUT and COMPARE_OUT.
        """
        levels = ctypes.POINTER(ctypes.c_uint16)()
        number = self.library.instrument_traced(self.handle, ctypes.byref(levels))
        return _array(levels, number, np.uint16)

    def _measure_latency(self) -> float:
        self.reset()
        self.write("output_spacing", 1)
        self.update("control", output_enable=1)
        self.run(100)
        count = np.arange(1, _LATENCY_EDGES + 1)
        levels = np.array([0, 1, 3, 2], dtype=np.uint8)[count % 4]
        self.attach_pins(PinEvents(0, count * _LATENCY_SPACING_CLOCKS, levels))
        clocks = (_LATENCY_EDGES + 100) * _LATENCY_SPACING_CLOCKS
        self.trace(clocks)
        self.run(clocks)
        traced = self.traced()
        self.detach()
        went_in = np.flatnonzero(np.diff(traced & 3, prepend=0))
        came_out = np.flatnonzero(np.diff(traced >> 6 & 3, prepend=0))
        if went_in.size != _LATENCY_EDGES or came_out.size != _LATENCY_EDGES:
            raise InstrumentError(
                f"of {_LATENCY_EDGES} edges at head 1 {came_out.size} came out of the core: "
                f"the netlist is not that of a working core"
            )
        return float(np.mean(came_out - went_in))


def _array(pointer: Any, number: int, kind: Any) -> NDArray[Any]:
    if not number:
        return np.zeros(0, dtype=kind)
    return np.ctypeslib.as_array(pointer, shape=(number,)).astype(kind, copy=True)
