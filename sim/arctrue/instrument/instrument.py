"""Provides the virtual instrument: the compiled core, its firmware, and recordings of its edges."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from arctrue.base.progress import ReportStep
from arctrue.generated.number_formats import CAPTURE_DEPTH_DEFAULT, CLOCK_HZ, LANES_DEFAULT
from arctrue.instrument.build import build
from arctrue.instrument.core_on_bus import CoreOnBus
from arctrue.instrument.errors import InstrumentError
from arctrue.instrument.firmware import Firmware
from arctrue.instrument.library import TrackView, load
from arctrue.instrument.recording import EdgeTrack, Recording
from arctrue.instrument.run_progress import ReportRun
from arctrue.table import PinEvents

_LATENCY_EDGES = 48
_LATENCY_SPACING_CLOCKS = 9


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


class Instrument(CoreOnBus):
    """One virtual instrument, used as a context manager; its library is built on first use.

    Parameters
    ----------
    lanes : int, optional
        Number of lanes of the core.
    capture_depth : int, optional
        Number of samples of a capture bank.
    clock_hz : float, optional
        Clocks of the gateware per second of table time. A value below the real 100 MHz needs fewer
        clocks for the same motion of the table, see :func:`clock_hz_for`.
    generics : mapping of str to int or str, optional
        Further generics of arctrue_core, by name.
    report_run : callable, optional
        Receives the progress of a run.
    progress_every_s : float, optional
        Seconds between two reports of the progress.
    report_step : callable, optional
        Receives a sentence for each step of the build.
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
        """Build and load the library of the instrument. Raises InstrumentError."""
        library = load(build(lanes, capture_depth, generics=generics, report_step=report_step))
        super().__init__(library, clock_hz, report_run, progress_every_s)
        self._recorded_counts_per_rev = 0
        self._firmware: Firmware | None = None
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
        if self._firmware is not None:
            self._firmware.close()
            self._firmware = None
        super().close()

    @property
    def firmware(self) -> Firmware:
        """The firmware that acts as the processor; it is created at the first use."""
        if self._firmware is None:
            self._firmware = Firmware(self)
        return self._firmware

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
                f"of {_LATENCY_EDGES} edges at head 1, {came_out.size} came out of the core: "
                f"the netlist is not that of a working core"
            )
        return float(np.mean(came_out - went_in))


def _array(pointer: Any, number: int, kind: Any) -> NDArray[Any]:
    if not number:
        return np.zeros(0, dtype=kind)
    return np.ctypeslib.as_array(pointer, shape=(number,)).astype(kind, copy=True)
