"""Captures turns as measurement sets in a folder, through the daemon's own console."""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path

from arctrue.device.announcement import Announcement
from arctrue.device.connection import console_through
from arctrue.device.dated_set import write_dated_set

_NAME = re.compile(r"\d{8}T\d{6}Z(-\d+)?-(schedule|alarm|asked)")
_STEP_NS = 1_000_000_000
"""Step between the times of two folders in nanoseconds; a file system may store whole seconds."""


def take_capture(daemon: Announcement, folder: Path, why: str, timeout_s: float) -> Path:
    """Capture the next turn, write it as a measurement set, and return the set's folder; the call
    blocks during the transfer.

    Raises ConsoleError, OSError, MeasurementError or ValueError.
    """
    console = console_through(daemon)
    try:
        measurement = console.dump(timeout_s)
    finally:
        console.close()
    path = write_dated_set(folder, measurement, why)
    mark_latest(path)
    return path


def mark_latest(path: Path) -> None:
    """Give a new set's folder a time after those of all earlier sets, so that the times have the
    order of the captures even after the system's clock was set back. Raises OSError."""
    others = (one for one in _made(path.parent) if one != path)
    latest_ns = max((one.stat().st_mtime_ns for one in others), default=0)
    time_ns = max(path.stat().st_mtime_ns, latest_ns + _STEP_NS)
    os.utime(path, ns=(time_ns, time_ns))


def drop_oldest(folder: Path, most: int) -> None:
    """Delete the oldest sets that the daemon made, by the times of their folders, until ``most`` of
    them remain; other sets are not deleted."""
    made = sorted(_made(folder), key=lambda path: (path.stat().st_mtime_ns, path.name))
    for path in made[: max(len(made) - most, 0)]:
        shutil.rmtree(path, ignore_errors=True)


def _made(folder: Path) -> list[Path]:
    return [path for path in folder.iterdir() if _NAME.fullmatch(path.name)]
