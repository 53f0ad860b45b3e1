"""Lists the quantities of a measurement set, and the units in which other programs write them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Literal

from arctrue.base.units import ARCSEC_PER_TURN

Kind = Literal["angle", "time", "temperature", "whole"]

QUANTITIES: Mapping[str, Kind] = {
    "time": "time",
    "target": "angle",
    "error": "angle",
    "head1": "angle",
    "head2": "angle",
    "head3": "angle",
    "head4": "angle",
    "run": "whole",
    "cycle": "whole",
    "direction": "whole",
    "temperature": "temperature",
    "u": "angle",
    "mask": "whole",
}
"""Kind of each quantity. ``target``: true angle by the reference. ``error``: ``head1`` minus
``target``. ``u``: standard uncertainty of the row. Every other name is a condition."""

HEADS = ("head1", "head2", "head3", "head4")

UNITS: Mapping[Kind, Mapping[str, float]] = {
    "angle": {  # number of units in one turn
        "deg": 360.0,
        "rad": 6.283185307179586,
        "mrad": 6283.185307179586,
        "urad": 6283185.307179586,
        "gon": 400.0,
        "arcmin": 21600.0,
        "arcsec": float(ARCSEC_PER_TURN),
        "hours": 24.0,
        "turns": 1.0,
        "counts": 0.0,  # counts_per_rev states their number
    },
    "time": {  # number of units in one second
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
    "º": "deg",
    "gradi": "deg",
    "grados": "deg",
    "degrés": "deg",
    "d:m:s": "deg",
    "dms": "deg",
    "h:m:s": "hours",
    "hms": "hours",
    "radian": "rad",
    "radians": "rad",
    "gons": "gon",
    "µrad": "urad",
    "μrad": "urad",
    '"': "arcsec",
    "″": "arcsec",
    "as": "arcsec",
    "''": "arcsec",
    "bogensekunden": "arcsec",
    "arcseconds": "arcsec",
    "arcsecs": "arcsec",
    "′": "arcmin",
    "'": "arcmin",
    "bogenminuten": "arcmin",
    "arcminutes": "arcmin",
    "turn": "turns",
    "rev": "turns",
    "revs": "turns",
    "revolutions": "turns",
    "umdr": "turns",
    "umdrehungen": "turns",
    "inkremente": "counts",
    "impulse": "counts",
    "pulses": "counts",
    "count": "counts",
    "cts": "counts",
    "ticks": "counts",
    "hr": "hours",
    "sec": "s",
    "second": "s",
    "seconds": "s",
    "sek": "s",
    "sekunden": "s",
    "secondes": "s",
    "segundos": "s",
    "secondi": "s",
    "µs": "us",
    "usec": "us",
    "msec": "ms",
    "minutes": "min",
    "minuten": "min",
    "std": "h",
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
GRAD = "grad"
"""Name of a unit that means degrees in German and gon in English."""
_GRAD = re.compile(r"(?<![^\W_])grad(?![^\W_])", re.IGNORECASE)
_WITH_UNIT = re.compile(
    r"^(?P<name>.*?)\s*(?:[\[(](?P<within>[^\])]+)[\])]|_(?P<after>[^_\s]+)"
    r"|(?:/|,|\bin\b)\s*(?P<last>[^/,\s]+))$"
)


def unit_named(kind: Kind, text: str) -> str | None:
    """Return the unit that ``text`` (``degrees``, ``″``) denotes; None if it denotes no unit of
    this kind."""
    text = text.strip()
    for word in (text, text.lower()):
        word = _WRITTEN.get(word, word)
        if word in UNITS[kind]:
            return word
    return None


def name_and_unit(kind: Kind, column: str) -> tuple[str, str | None]:
    """Split a column's name into name and unit: ``Az [deg]``, ``az_deg``, ``Az / deg``."""
    found = _WITH_UNIT.match(column.strip())
    if found is None:
        return column.strip(), None
    unit = unit_named(kind, found["within"] or found["after"] or found["last"])
    return (found["name"], unit) if unit is not None else (column.strip(), None)


def any_unit(text: str) -> bool:
    """Tell whether the text denotes a unit of any kind."""
    return text.lower() == GRAD or any(unit_named(kind, text) for kind in UNITS if kind != "whole")


def may_be_grad(column: str) -> bool:
    """Tell whether the column's name contains the word grad, which means gon or degree."""
    return _GRAD.search(column) is not None
