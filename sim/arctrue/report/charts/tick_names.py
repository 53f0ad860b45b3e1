"""Arranges horizontal names of ticks, so that they do not overlap each other or the end of the
axis."""

from __future__ import annotations

import math
import textwrap

from arctrue.report.charts.chart import Axis

_SHORT_LETTERS = 5
"""A name with at most this many letters counts as a number; some numbers may be omitted. Longer
names are words."""
_LEAST_WRAPPED, _MOST_LINES = 8, 5
"""Smallest number of letters per line at which words are readable; largest number of lines below a
tick."""
_SHORTER = "…"


def tick_names(axis: Axis, letters: float) -> list[tuple[float, str]]:
    """Return the ticks with names that fit an axis with room for ``letters`` letters.

    If there is no room for all numbers, only every second, third, … number is kept. Words are
    wrapped to the width of a tick; if this width is too narrow to read, only the first word is
    kept.
    """
    ticks = list(axis.ticks or ())
    longest = max((len(line) for _, name in ticks for line in name.split("\n")), default=1)
    if longest <= _SHORT_LETTERS:
        return ticks[:: max(math.ceil(len(ticks) * (longest + 1) / max(letters, 1.0)), 1)]
    room = int(letters / len(ticks)) - 1
    return [(place, _in_lines(name, room)) for place, name in ticks]


def tick_lines(ticks: list[tuple[float, str]]) -> int:
    """Return the number of lines of the tick name that has most lines."""
    return max((name.count("\n") + 1 for _, name in ticks), default=1)


def _in_lines(name: str, letters: int) -> str:
    if letters < _LEAST_WRAPPED:
        return name.split()[0][: max(letters, 1)]
    wrapped = [
        part
        for line in name.split("\n")
        for part in textwrap.wrap(
            " ".join(_hyphenated(word, letters) for word in line.split()),
            letters,
            break_long_words=False,
        )
    ]
    if len(wrapped) > _MOST_LINES:
        wrapped = [*wrapped[: _MOST_LINES - 1], wrapped[_MOST_LINES - 1][: letters - 1] + _SHORTER]
    return "\n".join(wrapped)


def _hyphenated(word: str, letters: int) -> str:
    """Divide a word that is longer than a line into hyphenated pieces."""
    if len(word) <= letters:
        return word
    pieces = textwrap.wrap(word, letters - 1, break_on_hyphens=False)
    return "- ".join(pieces)
