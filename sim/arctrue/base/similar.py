"""Suggests known names that are similar to an unknown name."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

MOST = 3
LEAST_RATIO = 0.6
"""Smallest ratio of matching characters (difflib.SequenceMatcher.ratio) of a similar name."""


def similar(name: str, known: Iterable[str], least: float = LEAST_RATIO) -> list[str]:
    """Return at most MOST names of ``known``: names spelt like ``name`` or, without such names,
    names that contain ``name``."""
    names = list(known)
    plain = name.lower().replace("-", "_")
    close = difflib.get_close_matches(plain, names, n=MOST, cutoff=least)
    if close or len(plain) < 3:
        return close
    return [one for one in names if plain in one][:MOST]


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return `` Did you mean hysteresis?`` with a leading space; empty if no name is similar."""
    found = similar(name, known)
    return f" Did you mean {' or '.join(found)}?" if found else ""
