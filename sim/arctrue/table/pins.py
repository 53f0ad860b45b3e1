"""Computes the levels of the heads' A, B and Z wires, and the clocks of the electronics at which
they change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arctrue.base.whole_file import whole_file
from arctrue.table.edges import CountEdges

PIN_A, PIN_B, PIN_Z = 1, 2, 4
PINS_A_HEAD = 3

# When the table turns counter-clockwise, A leads B: (A, B) goes 00, 10, 11, 01 with rising count
# (figure 4 of the paper).
_QUADRATURE = np.array([0, PIN_A, PIN_A | PIN_B, PIN_B], dtype=np.uint8)


class TooFastError(ValueError):
    """Is raised if the table turns faster than the electronics can follow."""


def pin_states(
    count: NDArray[np.int64], counts_per_rev: int, index_width_counts: int = 1
) -> NDArray[np.uint8]:
    """Return the levels of A (bit 0), B (bit 1) and Z (bit 2) at each count.

    Parameters
    ----------
    count : ndarray
        Counts from the head's index, not wrapped, shape (n,).
    counts_per_rev : int
        Counts a turn.
    index_width_counts : int
        Number of counts from count 0 of every turn for which Z is high.

    Returns
    -------
    ndarray
        Levels, shape (n,).
    """
    at_index = count % counts_per_rev < index_width_counts
    return _QUADRATURE[count % 4] | np.where(at_index, PIN_Z, 0).astype(np.uint8)


@dataclass(frozen=True, slots=True)
class PinEvents:
    """Changes of the levels of several pins, in arrays ``(n,)`` with strictly rising clocks.

    As text the events are a line ``0 levels`` and then a line ``clocks-since-last levels`` for each
    event. tb/support/edge_player.vhd plays this text and tb/support/edge_recorder.vhd writes it.
    """

    first_levels: int
    """Levels of all pins before the first event, one bit a pin."""
    clock: NDArray[np.int64]
    """Clock of each event."""
    levels: NDArray[np.uint8]
    """Levels of all pins after each event, one bit a pin."""

    def write(self, file: Path) -> None:
        """Write the events to a file as text.

        Parameters
        ----------
        file : Path
            The file, which is replaced as a whole.

        Raises
        ------
        ValueError
            If the events are not in order, or the first is at clock 0.
        OSError
            If the file cannot be written.
        """
        deltas = np.diff(self.clock, prepend=0)
        if deltas.size and deltas.min() < 1:
            raise ValueError(f"{file}: events must be in order, the first after clock 0")
        rows = np.column_stack([deltas, self.levels.astype(np.int64)])
        with whole_file(file) as unfinished, unfinished.open("w", encoding="ascii") as text:
            text.write(f"0 {self.first_levels}\n")
            np.savetxt(text, rows, fmt="%d")

    @classmethod
    def read(cls, file: Path) -> PinEvents:
        """Read events from a file that :meth:`write` or the recorder in VHDL wrote.

        Parameters
        ----------
        file : Path
            The file.

        Returns
        -------
        PinEvents
            The events of the file.

        Raises
        ------
        ValueError
            If the file is missing or empty, or a line has other than two numbers.
        """
        if not file.exists() or not file.stat().st_size:
            raise ValueError(f"{file}: no pin events; did the simulation run to its end?")
        rows = np.loadtxt(file, dtype=np.int64, ndmin=2)
        if rows.shape[1] != 2:
            raise ValueError(f"{file}: expected two numbers a line, found {rows.shape[1]}")
        clock = np.cumsum(rows[1:, 0])
        return cls(int(rows[0, 1]), clock, rows[1:, 1].astype(np.uint8))


def clocked_pins(
    heads: Sequence[CountEdges],
    counts_per_rev: int,
    clock_hz: float,
    index_width_counts: int = 1,
) -> PinEvents:
    """Sample the wires of all heads at each clock; the lowest bits are those of head 1.

    Parameters
    ----------
    heads : sequence of CountEdges
        Edges of each head.
    counts_per_rev : int
        Counts a turn.
    clock_hz : float
        Clocks a second of table time.
    index_width_counts : int
        Width of Z in counts.

    Returns
    -------
    PinEvents
        Changes of all wires; an edge appears at the first clock at or after its time.

    Raises
    ------
    TooFastError
        If two edges of one head fall on one clock, because the electronics would detect an illegal
        transition; the message names head and time.
    """
    first_levels = 0
    clocks, owners, levels = [], [], []
    for number, edges in enumerate(heads):
        clock = np.ceil(edges.time_s * clock_hz).astype(np.int64)
        crowded = np.flatnonzero(np.diff(clock) < 1)
        if crowded.size:
            at = crowded[0]
            raise TooFastError(
                f"head {number + 1}: two count edges on one clock at {edges.time_s[at]:.6g} s "
                f"({crowded.size} such places); turn the table slower or raise the clock of "
                f"{clock_hz:g} Hz"
            )
        shift = PINS_A_HEAD * number
        state = pin_states(edges.count, counts_per_rev, index_width_counts)
        first = pin_states(np.array([edges.first_count]), counts_per_rev, index_width_counts)
        first_levels |= int(first[0]) << shift
        clocks.append(clock)
        owners.append(np.full(clock.size, number))
        levels.append(state)
    clock = np.concatenate(clocks)
    order = np.argsort(clock, kind="stable")
    clock, owner = clock[order], np.concatenate(owners)[order]
    level = np.concatenate(levels)[order]
    bundle = np.zeros(clock.size, dtype=np.int64)
    for number in range(len(heads)):
        shift = PINS_A_HEAD * number
        own = np.concatenate([[first_levels >> shift & 7], level[owner == number]])
        bundle |= own[np.cumsum(owner == number)].astype(np.int64) << shift
    last_on_clock = np.append(np.diff(clock) > 0, True) if clock.size else np.zeros(0, dtype=bool)
    # Clock 0 has the state before the first event, so events begin at clock 1.
    return PinEvents(first_levels, clock[last_on_clock], bundle[last_on_clock].astype(np.uint8))


def decode_quadrature(
    first_levels: int, levels: NDArray[np.uint8]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the steps and the illegal transitions of recorded A/B/Z levels.

    Parameters
    ----------
    first_levels : int
        Levels before the first event.
    levels : ndarray
        Levels after each event as in :func:`pin_states`, shape (n,).

    Returns
    -------
    step : ndarray
        Step at each event, −1, 0 or +1, shape (n,).
    illegal : ndarray
        Indices of the events at which A and B changed together, shape (k,).
    """
    phase_of = np.array([0, 1, 3, 2])  # index A + 2·B; as the count rises, (A, B) is 00, 10, 11, 01
    phase = phase_of[np.concatenate([[first_levels], levels]).astype(np.int64) & 3]
    step = (np.diff(phase) + 1) % 4 - 1
    return np.where(step == 2, 0, step), np.flatnonzero(step == 2)
