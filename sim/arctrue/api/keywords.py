"""Converts the keywords that describe a table to the keys of ``measurement.toml``."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import date
from pathlib import Path
from typing import Any, TypedDict

from arctrue.base.similar import did_you_mean
from arctrue.base.typed_content import ContentError, typed
from arctrue.measurement import MeasurementError
from arctrue.measurement.description import Keys

SECTION_OF = {
    **dict.fromkeys(
        (
            *("counts_per_rev", "grating_lines", "disc_diameter_mm", "head_separation_deg"),
            *("head_places_deg", "index_detection_arcsec", "drive_gear_teeth"),
            "index_repeatability_counts",
        ),
        "table",
    ),
    "clock_hz": "capture",
    **dict.fromkeys(
        ("instrument", "faces", "standard_uncertainty_arcsec", "clock_offset_s"), "reference"
    ),
}
"""Section of ``measurement.toml`` for each keyword."""
TEXTS = ("title", "date")
"""Keywords that stand before the first section of ``measurement.toml``."""


class Metadata(TypedDict, total=False):
    """Description of table, heads and reference: the keys of ``measurement.toml``."""

    title: str
    date: str
    counts_per_rev: int
    head_separation_deg: float
    head_places_deg: tuple[float, ...]
    index_detection_arcsec: float
    index_repeatability_counts: float
    grating_lines: int
    disc_diameter_mm: float
    drive_gear_teeth: float
    clock_hz: float
    instrument: str
    faces: int
    standard_uncertainty_arcsec: float
    clock_offset_s: float


def keys_of(metadata: Mapping[str, Any]) -> Keys:
    """Build the description of the table from the keywords.

    Raises TypeError, MeasurementError.
    """
    content: dict[str, Any] = {"schema": 1, "table": {}, "capture": {}, "reference": {}}
    for name, value in metadata.items():
        if value is None:
            continue
        plain = value.tolist() if hasattr(value, "tolist") else value
        plain = list(plain) if isinstance(plain, tuple) else plain
        if name in TEXTS:
            content[name] = plain.isoformat() if isinstance(plain, date) else plain
        elif name in SECTION_OF:
            content[SECTION_OF[name]][name] = plain
        else:
            known = (*SECTION_OF, *TEXTS)
            raise TypeError(
                f"{name} is not known.{did_you_mean(name, known)} There are: {', '.join(known)}"
            )
    try:
        return typed(content, Keys)
    except ContentError as error:
        raise MeasurementError("value", Path("keywords"), str(error)) from error


def known_attributes(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Return the attributes of a file or dataset that are keywords of :class:`Metadata`."""
    found = {}
    for name in (*SECTION_OF, *TEXTS):
        if name in attributes:
            value = attributes[name]
            found[name] = value.decode() if isinstance(value, bytes) else value
    return found
