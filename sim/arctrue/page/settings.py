"""Holds the settings with which ``arctrue serve`` was started."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path

MEGABYTE = 1_000_000


@dataclass(frozen=True)
class PageSettings:
    """Settings of the server. ``folder``: folder of the sets. ``state``: folder of the sessions.
    ``port``: serial port of a device, "" for none. ``device``: serial port of a device with a
    daemon, or HOST:PORT of the daemon; "" for none. ``hosts``: host names with port that a request
    may name; if empty, any name."""

    folder: Path
    state: Path
    effect_folders: tuple[Path, ...] = ()
    most_bytes: int = 64 * MEGABYTE
    port: str = ""
    device: str = ""
    hosts: Collection[str] = field(default_factory=tuple)
    token: str = ""
