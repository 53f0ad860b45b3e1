"""Unit of a further column of a measurement set, as its name tells it."""

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
"""Unit by the last word of a column's name; of a difference, so that °C are K."""


def column_unit(column: str) -> str:
    """``elevation_deg``: ``deg``. A name that ends in no unit is its own unit: ``[humidity]``."""
    first, _, last = column.rpartition("_")
    return UNITS.get(last.lower(), f"[{column}]") if first else f"[{column}]"
