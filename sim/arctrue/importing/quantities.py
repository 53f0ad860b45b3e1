"""The quantities of a measurement set and the units in which other programs write them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Literal

from arctrue.units import ARCSEC_PER_TURN

Kind = Literal["angle", "time", "temperature", "whole"]

QUANTITIES: Mapping[str, Kind] = {
    "time": "time",
    "target": "angle",
    "error": "angle",
    "head1": "angle",
    "head2": "angle",
    "run": "whole",
    "cycle": "whole",
    "direction": "whole",
    "temperature": "temperature",
    "u": "angle",
    "mask": "whole",
}
"""``target``: the angle by the reference. ``error``: ``head1`` less ``target``. ``u``: standard
uncertainty of the row. Any other name is a condition."""

UNITS: Mapping[Kind, Mapping[str, float]] = {
    "angle": {  # of one turn
        "deg": 360.0,
        "rad": 6.283185307179586,
        "mrad": 6283.185307179586,
        "gon": 400.0,
        "arcmin": 21600.0,
        "arcsec": float(ARCSEC_PER_TURN),
        "hours": 24.0,
        "turns": 1.0,
        "counts": 0.0,  # counts_per_rev says how many
    },
    "time": {  # of one second
        "s": 1.0,
        "ms": 1e3,
        "us": 1e6,
        "ns": 1e9,
        "min": 1.0 / 60.0,
        "h": 1.0 / 3600.0,
        "days": 1.0 / 86400.0,
        "iso": 1.0,  # text, ISO 8601
    },
    "temperature": {"degC": 1.0, "K": 1.0, "degF": 1.8},
    "whole": {"": 1.0},
}

_WRITTEN: Mapping[str, str] = {
    "degree": "deg",
    "degrees": "deg",
    "°": "deg",
    "radian": "rad",
    "radians": "rad",
    "gons": "gon",
    "grad": "gon",
    '"': "arcsec",
    "″": "arcsec",
    "as": "arcsec",
    "arcseconds": "arcsec",
    "arcsecs": "arcsec",
    "′": "arcmin",
    "arcminutes": "arcmin",
    "turn": "turns",
    "rev": "turns",
    "revs": "turns",
    "revolutions": "turns",
    "count": "counts",
    "cts": "counts",
    "ticks": "counts",
    "hr": "hours",
    "sec": "s",
    "seconds": "s",
    "µs": "us",
    "usec": "us",
    "msec": "ms",
    "minutes": "min",
    "day": "days",
    "°c": "degC",
    "c": "degC",
    "degc": "degC",
    "celsius": "degC",
    "k": "K",
    "kelvin": "K",
    "°f": "degF",
    "f": "degF",
    "degf": "degF",
}
_WITH_UNIT = re.compile(
    r"^(?P<name>.*?)\s*(?:[\[(](?P<within>[^\])]+)[\])]|_(?P<after>[^_\s]+)"
    r"|(?:/|,|\bin\b)\s*(?P<last>[^/,\s]+))$"
)


def unit_named(kind: Kind, text: str) -> str | None:
    """The unit that ``text`` writes (``degrees``, ``″``); None: no unit of this kind."""
    text = text.strip()
    for word in (text, text.lower()):
        word = _WRITTEN.get(word, word)
        if word in UNITS[kind]:
            return word
    return None


def name_and_unit(kind: Kind, column: str) -> tuple[str, str | None]:
    """A column's name without its unit, and the unit: ``Az [deg]``, ``az_deg``, ``Az / deg``."""
    found = _WITH_UNIT.match(column.strip())
    if found is None:
        return column.strip(), None
    unit = unit_named(kind, found["within"] or found["after"] or found["last"])
    return (found["name"], unit) if unit is not None else (column.strip(), None)
