"""Holds the settings of ``arctrue device run``."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from arctrue.device.port import BAUD
from arctrue.device.recorder import Retention


@dataclass(frozen=True)
class DaemonSettings:
    """Settings of the daemon. ``port``: the serial port; ``store``: folder of the record, of the
    captures, and of the file with the alarms of ``arctrue life``.

    ``capture_every_s``: time between scheduled captures, 0 for none. ``token``: token that every
    client must send.
    """

    port: str
    store: Path
    token: str
    host: str = "127.0.0.1"
    tcp_port: int = 0
    baud: int = BAUD
    allow_control: bool = False
    retention: Retention = field(default_factory=Retention)
    capture_every_s: float = 0.0
    capture_on_alarm: bool = True
    capture_pause_s: float = 600.0
    """Shortest time in seconds between two captures that alarms cause."""
    most_captures: int = 500
    probe_every_s: float = 0.0
    """Time in seconds between two requests for events of probe and compare; 0: no requests."""
    files: Path | None = None
    """Folder of the daily NeXus files; None: no files."""
    files_every_s: float = 6.0
    capture_timeout_s: float = 180.0

    @property
    def record(self) -> Path:
        """Return the path of the SQLite file with the telemetry."""
        return self.store / "telemetry.sqlite"

    @property
    def machine_alarms(self) -> Path:
        """Return the path of the file with the alarms of ``arctrue life``, for the next start."""
        return self.store / "machine_alarms.json"

    @property
    def zero(self) -> Path:
        """Return the path of the file with the zero of another axis, for the next start."""
        return self.store / "zero.json"

    @property
    def captures(self) -> Path:
        """Return the folder of the captures."""
        return self.store / "captures"
