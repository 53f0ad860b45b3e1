"""Parses sexagesimal angles and times: ``-12:34:56.7``, ``12°34′56.7″``, ``12 34 56.7``."""

from __future__ import annotations

import re

_NUMBER = r"\d+(?:[.,]\d*)?"
_COLONS = re.compile(rf"([+-]?)(\d+):(\d{{1,2}}):({_NUMBER})\Z")
_SPACES = re.compile(rf"([+-]?)(\d+) +(\d{{1,2}}) +({_NUMBER})\Z")
_SIGNS = re.compile(
    rf"([+-]?)\s*({_NUMBER})\s*[°dh]\s*(?:({_NUMBER})\s*(?:['′m](?!['′])))?\s*"
    rf"(?:({_NUMBER})\s*(?:[\"″s]|''|′′))?\Z"
)
OF_DEGREES = ("°", "d")
"""Signs that mark an angle in degrees; a sexagesimal text without such a sign may be in hours."""


def is_sexagesimal(text: str, *, spaces: bool = True) -> bool:
    """Tell whether the text is sexagesimal; ``spaces`` permits texts with only spaces between the
    parts."""
    return _match(text, spaces=spaces) is not None


def sexagesimal(text: str) -> float | None:
    """Convert a text to degrees or hours; return None if it is not sexagesimal.

    Minutes and seconds must be below 60. The sign applies to all parts.
    """
    found = _match(text, spaces=True)
    if found is None:
        return None
    whole, minutes, seconds = (
        float((part or "0").replace(",", ".")) for part in found.groups()[1:]
    )
    if minutes >= 60.0 or seconds >= 60.0:
        return None
    size = whole + minutes / 60.0 + seconds / 3600.0
    return -size if found[1] == "-" else size


def _match(text: str, *, spaces: bool) -> re.Match[str] | None:
    text = text.strip()
    found = _COLONS.match(text) or _SIGNS.match(text)
    return found or (_SPACES.match(text) if spaces else None)
