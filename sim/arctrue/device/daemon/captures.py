"""Captures turns as measurement sets in a folder, through the daemon's own console."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

from arctrue.device.announcement import Announcement
from arctrue.device.connection import console_through
from arctrue.device.dated_set import write_dated_set

_NAME = re.compile(r"\d{8}T\d{6}Z(-\d+)?-(schedule|alarm|asked)")


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
    return write_dated_set(folder, measurement, why)


def drop_oldest(folder: Path, most: int) -> None:
    """Delete the oldest sets that the daemon made until ``most`` of them remain; other sets are not
    deleted."""
    made = sorted(path for path in folder.iterdir() if _NAME.fullmatch(path.name))
    for path in made[: max(len(made) - most, 0)]:
        shutil.rmtree(path, ignore_errors=True)
