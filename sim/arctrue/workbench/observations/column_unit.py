"""Finds the unit of a user's additional column of a measurement set from the column's name."""

from __future__ import annotations

UNITS = {
    "deg": "deg",
    "rad": "rad",
    "nm": "N·m",
    "n": "N",
    "kg": "kg",
    "a": "A",
    "v": "V",
    "w": "W",
    "c": "K",
    "k": "K",
    "hpa": "hPa",
    "pa": "Pa",
    "percent": "%",
    "pct": "%",
    "mm": "mm",
    "um": "um",
    "s": "s",
    "hz": "Hz",
    "rpm": "rpm",
}
"""Unit of a column for each last word of a column's name. The unit applies to differences of
values; for a column in °C it is K."""


def column_unit(column: str) -> str:
    """Return the unit of a column, such as ``deg`` for ``elevation_deg``.

    If the name states no unit, the unit is the name in brackets, such as ``[humidity]``.
    """
    first, _, last = column.rpartition("_")
    return UNITS.get(last.lower(), f"[{column}]") if first else f"[{column}]"
