"""Writes a captured turn as a measurement set whose name and description state the present time."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from arctrue.measurement import MeasurementSet, write_measurement_set


def write_dated_set(folder: Path, measurement: MeasurementSet, *ending: str) -> Path:
    """Write a set whose date is the present time; return the set's folder.

    The name in ``folder`` is the time in UTC, a number from 2 if a set has this time already, and
    ``ending``. Raises OSError, MeasurementError or ValueError.
    """
    now = datetime.now(UTC).replace(microsecond=0)
    moment = now.strftime("%Y%m%dT%H%M%SZ")
    path, number = folder / "-".join([moment, *ending]), 1
    while path.exists():
        number += 1
        path = folder / "-".join([moment, str(number), *ending])
    write_measurement_set(path, replace(measurement, date=now))
    return path
