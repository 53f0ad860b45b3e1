"""Corrected positions that a probe's edges latched, read over the console."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass

from arctrue.device.console import Console, ConsoleError

EDGES_WRAP = 1 << 16
LOOK_S = 0.1
"""Between two looks at the device. Of edges that come faster the last one is seen."""
CSV_HEAD = "edge,time_s,position_counts,angle_deg"


@dataclass(frozen=True, slots=True)
class Latch:
    """Where the table was at an edge of the probe."""

    edge: int
    """Edges since the reset of the device, modulo 2¹⁶."""
    time_s: float
    """Of the device's clock."""
    position_counts: int
    """Corrected, over many turns."""
    angle_deg: float
    """Corrected, after the index."""
    missed: int
    """Edges between the one before and this one, whose positions nobody read."""

    def as_csv(self) -> str:
        """A row below CSV_HEAD."""
        return f"{self.edge},{self.time_s:.9f},{self.position_counts},{self.angle_deg:.7f}"


class Probe:
    """The latch of a device; only edges from now on count."""

    def __init__(self, console: Console) -> None:
        """Raises ConsoleError where the device does not answer, or has no core with a probe."""
        self._console = console
        self._clock_hz = _value(_told(console, "version"), "clock_hz", console)
        parameters = _told(console, "show parameters")
        self._counts_per_rev = _value(parameters, "counts_per_rev", console)
        self._edge = int(self._read("edges"))
        self._latest: dict[str, str] = {}

    def wait(self, seconds: float) -> Latch | None:
        """The next edge, None where none came within ``seconds``. Raises ConsoleError."""
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
    """All of a recording as the text of a file."""
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
