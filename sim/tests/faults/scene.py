"""Defines a scene: an instrument with a simulated table and the firmware, whose output and
uncorrected reading are compared with the true angle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sim.tests.faults.setting import (
    ARCSEC_A_COUNT,
    CLOCKS_A_COUNT,
    COUNTS,
    FOLLOWING_LIMIT_COUNTS,
    OUTPUT_SPACING_CLOCKS,
    PARAMETERS,
    PERIOD_COUNTS,
    POLL_CLOCKS,
    SEPARATION_RAD,
    SPEED_RAD_S,
    TURN_CLOCKS,
    TURN_RAD,
    steady,
    table,
    true_error_counts,
)
from sim.tests.instrument.sizes import DEPTH, LANES

from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.correction_ramp import ramp_arcsec_s
from arctrue.instrument import (
    HEAD1_A,
    HEAD1_B,
    EdgeTrack,
    Firmware,
    Instrument,
    PinFault,
    Recording,
    clock_hz_for,
)
from arctrue.table import Motion

BINS = 256
MEAN_ERROR = float(np.mean(true_error_counts(np.linspace(0.0, TURN_RAD, 4096, endpoint=False))))
"""Mean error of the geometry in counts, which the correction leaves and the comparison subtracts
with the zeros."""


@dataclass(frozen=True, slots=True)
class Comparison:
    """Errors of all edges of a recording against the true angle, in counts, by bins of the true
    angle.

    Head 1 may lose or gain counts on its wires. This slip is also in the output, because the
    correction cannot detect it; the slip is measured separately and subtracted from both errors.
    """

    corrected: NDArray[np.float64]
    """Largest |error − slip| of the output's edges in each bin; NaN in a bin without edges."""
    uncorrected: NDArray[np.float64]
    """Largest |error − slip| of head 1's uncorrected edges in each bin."""
    slip: NDArray[np.float64]
    """Slip of head 1 at each edge of head 1, from the harness's own decoder."""
    illegal: int
    """Number of clocks in which A and B of the output changed together."""
    edges: int

    @property
    def worse(self) -> float:
        """Return the largest value of ``corrected`` − ``uncorrected`` over the bins."""
        return float(np.nanmax(self.corrected - self.uncorrected))

    @property
    def most(self) -> float:
        """Return the largest |error − slip| of the output."""
        return float(np.nanmax(self.corrected))

    @property
    def most_slip(self) -> float:
        """Return the largest absolute slip over all edges."""
        return float(np.abs(self.slip).max(initial=0.0))

    @property
    def last_slip(self) -> int:
        """Return the slip at the end of the recording: the rounded mean of its last 20 edges."""
        return round(float(np.mean(self.slip[-20:])))


class Scene:
    """An instrument with a table and the firmware; a test first calls :meth:`calibrate`."""

    def __init__(
        self,
        motion: Motion | None = None,
        parameters: Mapping[str, float] | None = None,
        *faults: PinFault,
        flash: bytes | None = None,
        generics: Mapping[str, int | str] | None = None,
    ) -> None:
        """Set up the scene.

        The ``faults`` act from the beginning; the table may turn by more than one count per clock.
        ``generics`` are further generics of the core. ``flash`` is the flash content of a board
        that was calibrated before; with it, the scene sets no parameter.
        """
        clock_hz = clock_hz_for(COUNTS, SPEED_RAD_S, CLOCKS_A_COUNT)
        self.instrument = Instrument(LANES, DEPTH, clock_hz=clock_hz, generics=generics)
        self.instrument.attach(table(), motion or steady(), may_jump=True)
        self.instrument.disturb(*faults)
        firmware = self.instrument.firmware
        values = {**PARAMETERS, **(parameters or {})}
        self._ramp_counts_a_clock = values["ramp_arcsec_s"] / ramp_arcsec_s(2.0**35, COUNTS)
        if flash is None:
            for name, value in values.items():
                firmware.set(name, value)
            firmware.start()
        else:
            firmware.power_on(flash)
        self.instrument.write("following_limit", FOLLOWING_LIMIT_COUNTS)
        self._zeros = Zeros(0.0, 0.0)

    @property
    def firmware(self) -> Firmware:
        return self.instrument.firmware

    def calibrate(self, flag_reason: str | None = None) -> None:
        """Capture and apply the first turn; record the second turn to find the zeros of both
        tracks.

        With ``flag_reason`` a flag of a head is set, so that the first turn is refused for this
        reason. The next turn is refused, too, if it began before the firmware cleared the flag.
        """
        self.next_turn()
        if flag_reason is not None:
            assert self.last_reply["reason"] == flag_reason
            if self.next_turn()["reason"] == flag_reason:
                self.next_turn()
        assert self.last_reply["result"] == "applied"
        self.settle()
        self.record()
        self.turn(1.0)
        self._zeros = zeros_of(self.instrument)
        self.is_clean()
        assert not self.faults()

    # Time

    def turn(self, turns: float) -> None:
        """Let the table turn by this number of turns while the firmware works."""
        begin = self.instrument.true_angle_rad
        self.firmware.run(
            until=lambda _: abs(self.instrument.true_angle_rad - begin) >= turns * TURN_RAD,
            poll_clocks=POLL_CLOCKS,
        )

    def to_part(self, part: float) -> None:
        """Turn the table until the true angle is at this fraction of a turn."""
        turns = self.instrument.true_angle_rad / TURN_RAD
        self.turn((part - turns) % 1.0)

    def next_turn(self) -> dict[str, Any]:
        """Run until the firmware has reported one more turn and processed it completely."""
        replies = len(self.firmware.telemetry)
        self.firmware.run(
            until=lambda f: len(f.telemetry) > replies and f.phase != "swap",
            poll_clocks=POLL_CLOCKS,
        )
        return self.last_reply

    def settle(self) -> None:
        """Run until the ramp has ended."""
        self.firmware.run(
            until=lambda _: not self.instrument.read("status.ramp_busy"), poll_clocks=POLL_CLOCKS
        )

    def disturb(self, turns: float, **fault: Any) -> None:
        """Apply a fault to the pins now, for this number of turns; see PinFault."""
        self.instrument.disturb(
            PinFault(self.instrument.clock, round(turns * TURN_CLOCKS), **fault)
        )

    def drop(self, counts: int, also_low: int = 0) -> None:
        """Hold A and B of head 1 low for this number of counts. The fault begins and ends in a
        count in which both are low."""
        instrument, pins = self.instrument, HEAD1_A | HEAD1_B
        period_clocks = PERIOD_COUNTS * CLOCKS_A_COUNT
        begin = instrument.clock
        instrument.trace(2 * period_clocks)
        instrument.run(2 * period_clocks)
        low = instrument.traced() & pins == 0
        falls = begin + 1 + int(np.flatnonzero(~low[:-1] & low[1:])[0])
        # The fault starts two periods later, two clocks after the start of the count, because A and
        # B are low there; they are low again at its end.
        first = falls + 2 * period_clocks + 2
        fault = PinFault(first, counts * CLOCKS_A_COUNT, low=pins | also_low)
        instrument.disturb(fault)

    def recovers(self, most_turns: int = 4, *, refers: bool = False) -> None:
        """Check that after the fault the firmware calibrates again and the output is right.

        With ``refers``, the output has stopped with a fault: before the check, the operator clears
        the fault, and the output's receiver finds its zero again.
        """
        for _ in range(most_turns):
            if self.next_turn()["result"] != "refused":
                break
        assert self.last_reply["reason"] in ("none", "not_better")
        self.settle()
        if refers:
            assert "cannot_keep_up" in self.faults(), "only the operator clears the fault"
            assert self.firmware.send("clear_output").startswith("ok")
            self.record()
            self.turn(1.0)
            now = zeros_of(self.instrument)
            slip = now.head1 - self._zeros.head1
            self._zeros = replace(self._zeros, corrected=now.corrected - slip)
        self.record()
        self.turn(1.0)
        self.is_clean()
        assert not self.faults()

    def knows_the_separation(self) -> None:
        """Check that the latest turn measured the head separation to within two counts, one for the
        index of each head."""
        assert self.last_reply["separation"] == "measured"
        off_arcsec = (self.last_reply["separation_deg"] - np.rad2deg(SEPARATION_RAD)) * 3600
        assert abs(off_arcsec) < 2 * ARCSEC_A_COUNT

    # Reports

    @property
    def last_reply(self) -> dict[str, Any]:
        """Return the latest turn's telemetry."""
        return self.firmware.telemetry[-1]

    def reasons(self, first: int = 0) -> list[str]:
        """Return the reasons of all turns from ``first`` on."""
        return [reply["reason"] for reply in self.firmware.telemetry[first:]]

    def faults(self) -> set[str]:
        """Return the names of the set flags. These flags light the fault LED."""
        found = {
            f"{head}.{name}"
            for head in ("head1", "head2")
            for name in ("index_error", "illegal", "overspeed")
            if self.instrument.read(f"{head}.flags.{name}")
        }
        if self.instrument.read("status.cannot_keep_up"):
            found.add("cannot_keep_up")
        return found

    @property
    def coefficients(self) -> Coefficients:
        """Return the active bank."""
        active = self.firmware.coefficients
        assert active is not None
        return active

    def bank(self) -> tuple[Any, ...]:
        """Return the active bank in a form that can be compared."""
        active = self.coefficients
        return tuple(map(tuple, (active.phase_steps, active.phase_offsets, active.amplitudes)))

    # Output

    def record(self) -> None:
        """Begin to record edges for the comparison."""
        self.instrument.record(every=1)

    def compare(self, *, slips: bool = True) -> Comparison:
        """Compare every edge since the recording began. Without ``slips`` the comparison assumes
        that head 1 lost no counts."""
        return compare(self.instrument, self._zeros, slips)

    def is_clean(self) -> None:
        """Check that every recorded edge is within the bound, and that A and B never changed
        together."""
        found = self.compare()
        assert found.most < self.clean_bound
        assert found.illegal == 0

    # Bounds, in counts; docs/faults.md lists them

    @property
    def clean_bound(self) -> float:
        """Return the bound of a calibrated output without a fault.

        The bound is the sum of half a count of rounding, the wait of an edge for the spacing after
        the previous edge, the rounding to whole clocks, and five standard uncertainties of each of
        the first LANES orders of the first applied turn.
        """
        first = next(t for t in self.firmware.telemetry if t["result"] == "applied")
        estimate = 5 * sum(order[3] for order in first["harmonics"][:LANES]) / ARCSEC_A_COUNT
        return 0.5 + (OUTPUT_SPACING_CLOCKS + 1) / CLOCKS_A_COUNT + float(estimate)

    @property
    def slope(self) -> float:
        """Return a bound of the change of the correction per count of angle: Σ n·A_n·2π / counts
        per turn."""
        active = self.coefficients
        amplitude = np.abs(active.amplitudes) / 2.0**11
        return float(np.sum(amplitude * (active.phase_steps / 2.0**48) * TURN_RAD))

    @property
    def largest_correction(self) -> float:
        """Return the sum of all applied amplitudes, Σ A_n."""
        return float(np.sum(np.abs(self.coefficients.amplitudes)) / 2.0**11)

    @property
    def ramp_lag(self) -> float:
        """Return the largest lag of a ramp behind the table's error in counts; 0 if the ramp is
        faster.

        A ramp changes the correction linearly to its new value. It lags behind where the table's
        error changes faster than the ramp.
        """
        rate = self._ramp_counts_a_clock * CLOCKS_A_COUNT
        counts = self.largest_correction / rate
        return min(max(0.0, self.slope - rate) * counts, self.largest_correction)

    def wrong_place(self, slip_counts: float) -> float:
        """Return the largest error of the correction that results from a slip of head 1's angle."""
        return min(self.slope * abs(slip_counts), 2 * self.largest_correction)


def errors(track: EdgeTrack) -> NDArray[np.float64]:
    """Return the error, position − true angle, of every edge."""
    error: NDArray[np.float64] = track.position - track.true_angle_rad * (COUNTS / TURN_RAD)
    return error


def slip_then(instrument: Instrument, recording: Recording, slip: NDArray[np.float64]) -> Any:
    """Return, for each edge of the output, head 1's slip at the edge that caused it."""
    came = recording.output.clock - round(instrument.latency_clocks)
    place = np.searchsorted(recording.head1.clock, came, side="right") - 1
    return slip[np.clip(place, 0, slip.size - 1)]


@dataclass(frozen=True, slots=True)
class Zeros:
    """Mean error of the output and mean slip of head 1, in counts, in a turn without a fault. They
    are not 0, because positions count from power-on."""

    corrected: float
    head1: float


def zeros_of(instrument: Instrument) -> Zeros:
    recording = instrument.recording()
    slip = errors(recording.head1) - true_error_counts(recording.head1.true_angle_rad)
    zero = float(slip.mean())
    return Zeros(float(np.mean(errors(recording.output))), zero)


def compare(instrument: Instrument, zeros: Zeros, slips: bool) -> Comparison:
    recording = instrument.recording()
    true = true_error_counts(recording.head1.true_angle_rad)
    slip = errors(recording.head1) - true - zeros.head1
    corrected = errors(recording.output) - zeros.corrected
    if slips and slip.size:
        corrected = corrected - slip_then(instrument, recording, slip)
    return Comparison(
        largest(recording.output, corrected),
        largest(recording.head1, true - MEAN_ERROR),
        slip,
        recording.illegal,
        recording.output.edges,
    )


def largest(track: EdgeTrack, error: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the largest |error| in each bin of the true angle."""
    place = np.floor(track.true_angle_rad / TURN_RAD % 1.0 * BINS).astype(np.int64) % BINS
    most = np.full(BINS, -np.inf)
    np.maximum.at(most, place, np.abs(error))
    return np.where(np.isinf(most), np.nan, most)
