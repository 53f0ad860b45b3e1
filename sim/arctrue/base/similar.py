"""Advice for a name that is not known: the known ones that look like it."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

MOST = 3
LEAST_RATIO = 0.6
"""Of matching letters (difflib.SequenceMatcher.ratio): its usual limit for words."""


def similar(name: str, known: Iterable[str], least: float = LEAST_RATIO) -> list[str]:
    """At most MOST of ``known``: those spelt like ``name``, else those that contain it."""
    names = list(known)
    plain = name.lower().replace("-", "_")
    close = difflib.get_close_matches(plain, names, n=MOST, cutoff=least)
    if close or len(plain) < 3:
        return close
    return [one for one in names if plain in one][:MOST]


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """`` Did you mean hysteresis?`` with its space before it; empty where nothing is like it."""
    found = similar(name, known)
    return f" Did you mean {' or '.join(found)}?" if found else ""
