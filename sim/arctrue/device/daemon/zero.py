"""Keeps the angle that another axis, such as a motor record, has at the device's index after the
homing of this axis."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import msgspec

from arctrue.base.whole_file import write_whole_text


def checked_zero(degrees: Any) -> float:
    """Return the angle at the index in degrees. Raises ValueError unless it is a finite number."""
    if isinstance(degrees, bool) or not isinstance(degrees, int | float):
        raise ValueError(f"expected a number of degrees, found {degrees!r}")
    try:
        found = float(degrees)
    except OverflowError:  # of a whole number above the range of a float
        found = math.inf
    if not math.isfinite(found):
        raise ValueError(f"expected a finite number of degrees, found {found}")
    return found


def read_zero(file: Path) -> float:
    """Return the zero that an earlier daemon kept, degrees; 0 if the file is missing or damaged."""
    try:
        return msgspec.json.decode(file.read_bytes(), type=float)
    except (OSError, msgspec.MsgspecError):
        return 0.0


def write_zero(file: Path, zero_deg: float) -> None:
    """Write the zero to the file, for a later daemon. Raises OSError."""
    write_whole_text(file, msgspec.json.encode(zero_deg).decode())
