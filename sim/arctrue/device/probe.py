"""Reads the corrected positions that a probe's edges latched, over the console."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass

from arctrue.device.console import Console, ConsoleError

EDGES_WRAP = 1 << 16
LOOK_S = 0.1
"""Time between two reads of the latch; of faster edges only the last one is seen."""
CSV_HEAD = "edge,time_s,position_counts,angle_deg"


@dataclass(frozen=True, slots=True)
class Latch:
    """Position of the table at an edge of the probe."""

    edge: int
    """Edges since the reset of the device, modulo 2¹⁶."""
    time_s: float
    """Time by the device's clock."""
    position_counts: int
    """Corrected position over many turns."""
    angle_deg: float
    """Corrected angle after the index."""
    missed: int
    """Edges between the previous one and this one, whose positions nobody read."""

    def as_csv(self) -> str:
        """Return a row below CSV_HEAD."""
        return f"{self.edge},{self.time_s:.9f},{self.position_counts},{self.angle_deg:.7f}"


class Probe:
    """The latch of a device; only edges from now on count."""

    def __init__(self, console: Console) -> None:
        """Connect. Raises ConsoleError if no device answers, or its core has no probe."""
        self._console = console
        self._clock_hz = _value(_told(console, "version"), "clock_hz", console)
        parameters = _told(console, "show parameters")
        self._counts_per_rev = _value(parameters, "counts_per_rev", console)
        self._edge = int(self._read("edges"))
        self._latest: dict[str, str] = {}

    def wait(self, seconds: float) -> Latch | None:
        """Return the next edge; None if none arrives within ``seconds``. Raises ConsoleError."""
        end = time.monotonic() + seconds
        while True:
            edge = int(self._read("edges"))
            if edge != self._edge:
                missed = (edge - self._edge) % EDGES_WRAP - 1
                self._edge = edge
                return self._latch(edge, missed)
            if time.monotonic() >= end:
                return None
            time.sleep(LOOK_S)

    def _read(self, name: str) -> float:
        self._latest = _told(self._console, "probe")
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


def _told(console: Console, command: str) -> dict[str, str]:
    lines = (line.split(" ", 1) for line in console.command(command))
    return {words[0]: words[1] for words in lines if len(words) == 2}


def _value(told: dict[str, str], name: str, console: Console) -> float:
    try:
        return float(told[name])
    except (KeyError, ValueError) as error:
        raise ConsoleError(
            f"{console.port}: the device does not tell {name}: does it have a core, and firmware "
            "that knows the command probe? `status` on its console tells"
        ) from error
