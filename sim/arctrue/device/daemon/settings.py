"""The settings of ``arctrue device run``."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from arctrue.device.port import BAUD
from arctrue.device.recorder import Retention


@dataclass(frozen=True)
class DaemonSettings:
    """``port``: the serial port; ``store``: folder of the record and of the captures.

    ``capture_every_s``: 0 means no schedule. ``token``: what every client must send.
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
    """From one capture for an alarm to the next."""
    most_captures: int = 500
    probe_every_s: float = 0.0
    """From one look at the latch of probe_in to the next; 0: none is taken."""
    files: Path | None = None
    """Folder of the NeXus files, one a day; None: none are written."""
    files_every_s: float = 3600.0
    capture_timeout_s: float = 180.0

    @property
    def record(self) -> Path:
        """The SQLite file of the telemetry."""
        return self.store / "telemetry.sqlite"

    @property
    def machine_alarms(self) -> Path:
        """The file that keeps the alarms of ``arctrue life`` over a restart."""
        return self.store / "machine_alarms.json"

    @property
    def captures(self) -> Path:
        """The folder of the captures."""
        return self.store / "captures"
