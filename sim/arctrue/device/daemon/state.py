"""Holds the present state of the daemon for its status answer and its metrics."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass
class DaemonState:
    """Counters since the daemon's start, and the latest turn."""

    port: str
    connected: bool = False
    reconnections: int = 0
    turns: int = 0
    damaged_lines: int = 0
    """Number of lines that began like telemetry and could not be read."""
    too_long_lines: int = 0
    unrecorded_turns: int = 0
    """Number of turns that could not be written to the record, for example because the disk was
    full."""
    recording: bool = True
    dropped_clients: int = 0
    captures: int = 0
    latest_capture: str = ""
    """Folder of the latest capture since the daemon's start."""
    failed_captures: int = 0
    probe_edges: int = 0
    """Number of events (edges at probe_in, pulses of compare_out) that the daemon has received."""
    probe_missed: int = 0
    """Number of these events that were missed, so that their positions are unknown."""
    watchers: int = 0
    console_in_use: bool = False
    alarms: list[str] = field(default_factory=list)
    """Names of the alarms that the device itself reports."""
    machine_alarms: dict[str, str] = field(default_factory=dict)
    """Alarms that ``arctrue life`` sent: the name of the parameter and the sentence about its
    limit."""
    zero_deg: float = 0.0
    """Angle in degrees that another axis, such as a motor record, has at the index."""
    latest: dict[str, Any] | None = None
    """Telemetry of the latest turn, with ``id`` and ``recorded_s``."""

    def as_dict(self) -> dict[str, Any]:
        """Return all values as values for JSON."""
        return asdict(self)
