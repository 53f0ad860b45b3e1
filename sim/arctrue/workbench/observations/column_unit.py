"""Finds the unit of a further column of a measurement set from the column's name."""

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
"""Unit of a column by the last word of its name. The unit applies to a difference, so that °C
become K."""


def column_unit(column: str) -> str:
    """Return the unit of a column, such as ``deg`` for ``elevation_deg``.

    If the name states no unit, the unit is the name in brackets, such as ``[humidity]``.
    """
    first, _, last = column.rpartition("_")
    return UNITS.get(last.lower(), f"[{column}]") if first else f"[{column}]"
