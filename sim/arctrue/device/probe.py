"""Reads the corrected positions at edges of probe_in and at pulses of compare_out, over the
console.

A core with the generic EVENTS keeps its events in a queue, so that edges may come in bursts. A core
without this queue has only a latch, which holds the last edge.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from arctrue.device.console import Console, ConsoleError

EDGES_WRAP: Final = 1 << 16
LOOK_S = 0.1
"""Time in seconds between two reads of the latch; if several edges occur in this time, only the
last one is read."""
QUEUE_LOOK_S = 0.02
"""Time in seconds between two reads of an empty queue; the queue holds 64 events."""
CSV_HEAD: Final = "edge,time_s,position_counts,angle_deg,kind,missed"
EVENTS_COMMAND: Final = "probe events"
KINDS: Final = {1: "probe", 2: "compare", 3: "probe and compare"}
"""Kinds of events with their names: an edge of probe_in, a pulse of compare_out, both in one
clock."""
_EVENT_WORDS: Final = 6


@dataclass(frozen=True, slots=True)
class Latch:
    """One event: the position of the table at an edge of the probe, or at a pulse of
    compare_out."""

    edge: int
    """Number of the event since the device's reset, modulo 2¹⁶."""
    time_s: float
    """Time of the event by the device's clock."""
    position_counts: int
    """Corrected position, counted over many turns."""
    angle_deg: float
    """Corrected angle from the index."""
    missed: int
    """Number of events between the previous event and this one that were missed, so that their
    positions are unknown."""
    kind: int = 1
    """Kind of the event, one of the keys of KINDS."""

    @property
    def missed_edges(self) -> str:
        """Return the numbers of the first and the last missed event."""
        first, last = (self.edge - self.missed) % EDGES_WRAP, (self.edge - 1) % EDGES_WRAP
        return f"{first}" if self.missed == 1 else f"{first} to {last}"

    def as_csv(self) -> str:
        """Return the event as a row of CSV with the columns of CSV_HEAD."""
        return (
            f"{self.edge},{self.time_s:.9f},{self.position_counts},{self.angle_deg:.7f},"
            f"{self.kind},{self.missed}"
        )


def missed_before(edge: int, before: int | None) -> int:
    """Return the number of events that were missed between ``before`` and ``edge``; 0 without an
    earlier event."""
    return 0 if before is None else (edge - before - 1) % EDGES_WRAP


def event_of(text: str, clock_hz: float, counts_per_rev: float, before: int | None) -> Latch | None:
    """Read a line ``event NUMBER KIND TIME POSITION ANGLE``; return None for any other or damaged
    line.

    ``before``: number of the previous event.
    """
    words = text.split()
    if len(words) != _EVENT_WORDS or words[0] != "event":
        return None
    try:
        edge, kind, clocks, position, angle = map(int, words[1:])
    except ValueError:
        return None
    if not 0 <= edge < EDGES_WRAP or kind not in KINDS:
        return None
    missed = missed_before(edge, before)
    return Latch(edge, clocks / clock_hz, position, angle / counts_per_rev * 360.0, missed, kind)


class Probe:
    """Reads the events of a device that occur after the connection was made."""

    def __init__(self, console: Console) -> None:
        """Connect to the device. Raises ConsoleError if no device answers, or its core has no
        probe."""
        self._console = console
        self._clock_hz = _value(_answers(console, "version"), "clock_hz", console)
        parameters = _answers(console, "show parameters")
        self._counts_per_rev = _value(parameters, "counts_per_rev", console)
        self._latest: dict[str, str] = {}
        self._waiting: deque[Latch] = deque()
        self._edge: int | None = None
        self.has_queue = self._forget_queue()
        """Whether the device has a queue of events."""
        if not self.has_queue:
            self._edge = int(self._read("edges"))

    def wait(self, seconds: float) -> Latch | None:
        """Return the next event; None if none arrives within ``seconds``. Raises ConsoleError."""
        end = time.monotonic() + seconds
        while True:
            found = self._next_in_queue() if self.has_queue else self._next_in_latch()
            if found is not None:
                return found
            if time.monotonic() >= end:
                return None
            time.sleep(QUEUE_LOOK_S if self.has_queue else LOOK_S)

    def _forget_queue(self) -> bool:
        """Read the events that wait in the queue; return False if the device has no queue."""
        try:
            self._read_queue()
        except ConsoleError as error:
            if "the device says error" in str(error):
                return False
            raise
        self._waiting.clear()
        return True

    def _next_in_queue(self) -> Latch | None:
        if not self._waiting:
            self._read_queue()
        return self._waiting.popleft() if self._waiting else None

    def _read_queue(self) -> None:
        """Read up to 64 events that wait in the queue."""
        for line in self._console.command(EVENTS_COMMAND):
            found = event_of(line, self._clock_hz, self._counts_per_rev, self._edge)
            if found is not None:
                self._edge = found.edge
                self._waiting.append(found)

    def _next_in_latch(self) -> Latch | None:
        edge = int(self._read("edges"))
        if edge == self._edge:
            return None
        missed, self._edge = missed_before(edge, self._edge), edge
        return self._latch(edge, missed)

    def _read(self, name: str) -> float:
        self._latest = _answers(self._console, "probe")
        return _value(self._latest, name, self._console)

    def _latch(self, edge: int, missed: int) -> Latch:
        def value(name: str) -> float:
            return _value(self._latest, name, self._console)

        return Latch(
            edge,
            value("time_clocks") / self._clock_hz,
            int(value("position_counts")),
            value("angle_counts") / self._counts_per_rev * 360.0,
            missed,
        )


def as_csv(latches: Iterable[Latch]) -> str:
    """Return a whole recording as the text of a file."""
    return "\n".join([CSV_HEAD, *(latch.as_csv() for latch in latches)]) + "\n"


def _answers(console: Console, command: str) -> dict[str, str]:
    lines = (line.split(" ", 1) for line in console.command(command))
    return {words[0]: words[1] for words in lines if len(words) == 2}


def _value(answers: dict[str, str], name: str, console: Console) -> float:
    try:
        return float(answers[name])
    except (KeyError, ValueError) as error:
        raise ConsoleError(
            f"{console.port}: the device does not state {name}: does it have a core, and firmware "
            "with the command probe? `status` on its console shows it"
        ) from error
