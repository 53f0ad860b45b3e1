"""The present state of the daemon, for its status and its metrics."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any


@dataclass
class DaemonState:
    """Counters since the start, and the latest turn."""

    port: str
    connected: bool = False
    reconnections: int = 0
    turns: int = 0
    damaged_lines: int = 0
    """Number of lines that began as telemetry and could not be read."""
    too_long_lines: int = 0
    unrecorded_turns: int = 0
    """Number of turns that the record could not store, for example because the disk was full."""
    recording: bool = True
    dropped_clients: int = 0
    captures: int = 0
    latest_capture: str = ""
    """Folder of the latest capture since the start."""
    failed_captures: int = 0
    probe_edges: int = 0
    """Number of edges at probe_in whose positions are recorded."""
    probe_missed: int = 0
    """Number of missed edges at probe_in, whose positions were not read."""
    watchers: int = 0
    console_in_use: bool = False
    alarms: list[str] = field(default_factory=list)
    """Names of the device's own alarms."""
    machine_alarms: dict[str, str] = field(default_factory=dict)
    """Alarms of ``arctrue life``: the parameter's name and the sentence about its limit."""
    latest: dict[str, Any] | None = None
    """The telemetry of the latest turn, with ``id`` and ``recorded_s``."""

    def as_dict(self) -> dict[str, Any]:
        """Return all values for JSON."""
        return asdict(self)
