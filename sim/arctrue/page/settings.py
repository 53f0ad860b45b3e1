"""What ``arctrue serve`` was started with."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field
from pathlib import Path

MEGABYTE = 1_000_000


@dataclass(frozen=True)
class PageSettings:
    """``folder``: of the sets. ``state``: of the sessions. ``port``: of a device; "": none.

    ``hosts``: names with port under which the server may be asked; empty: any.
    """

    folder: Path
    state: Path
    effect_folders: tuple[Path, ...] = ()
    most_bytes: int = 64 * MEGABYTE
    port: str = ""
    hosts: Collection[str] = field(default_factory=tuple)
    token: str = ""
