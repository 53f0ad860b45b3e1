"""Unit of a further column of a measurement set, from the column's name."""

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
"""Unit by the last word of a column's name. It is the unit of a difference, so that °C are K."""


def column_unit(column: str) -> str:
    """Return the unit: ``deg`` for ``elevation_deg``. A name without a unit becomes the unit:
    ``[humidity]``."""
    first, _, last = column.rpartition("_")
    return UNITS.get(last.lower(), f"[{column}]") if first else f"[{column}]"
