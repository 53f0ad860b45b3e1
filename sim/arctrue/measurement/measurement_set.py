"""A measurement set in memory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

SCHEMA = 1
CAPTURE_COLUMNS = ("run", "time_s", "head1_counts", "head2_counts")
CAPTURE_OPTIONAL = ("temperature_c",)
REFERENCE_COLUMNS = ("target_deg", "error_arcsec")
REFERENCE_OPTIONAL = ("run", "time_s", "cycle", "direction", "head1_counts", "temperature_c")
WHOLE_COLUMNS = ("run", "head1_counts", "head2_counts", "cycle", "direction")
"""Whole numbers in 64 bits; all other columns are floats."""

Integer = NDArray[np.int64]
Float = NDArray[np.float64]


@dataclass(frozen=True)
class Table:
    """The ``[table]`` of measurement.toml; None: not given."""

    counts_per_rev: int | None = None
    grating_lines: int | None = None
    disc_diameter_mm: float | None = None
    head_separation_deg: float | None = None
    index_detection_arcsec: float | None = None
    """Standard uncertainty of how far apart the heads detect the same index mark."""
    drive_gear_teeth: int | None = None
    faces: int | None = None


@dataclass(frozen=True)
class Capture:
    """Both heads over time, arrays (n,); the runs stand one after another."""

    run: Integer
    time_s: Float
    head1_counts: Integer
    head2_counts: Integer
    temperature_c: Float | None = None
    clock_hz: float | None = None


@dataclass(frozen=True)
class Reference:
    """Head 1 against a reference, arrays (n,); None: no such column or key."""

    target_deg: Float
    error_arcsec: Float
    run: Integer | None = None
    time_s: Float | None = None
    cycle: Integer | None = None
    direction: Integer | None = None
    head1_counts: Integer | None = None
    temperature_c: Float | None = None
    instrument: str | None = None
    faces: int | None = None
    standard_uncertainty_arcsec: float | None = None


@dataclass(frozen=True)
class MeasurementSet:
    """A whole set.

    ``other``: keys that this version does not know, by their dotted names; ``warnings``: what a
    person should be told, one sentence each; ``folder``: where it was read from.
    """

    table: Table
    capture: Capture | None = None
    reference: Reference | None = None
    title: str = ""
    other: Mapping[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    folder: Path | None = None
