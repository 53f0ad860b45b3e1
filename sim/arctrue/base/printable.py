"""Escapes characters that could move the cursor or hide text; formats remaining times."""

from __future__ import annotations

import math
import unicodedata

_REORDERING = frozenset("\u200e\u200f\u061c\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")
"""Characters that change the order in which a terminal shows letters (Unicode TR 9)."""
_UNPRINTABLE = frozenset({"Cc", "Cs", "Zl", "Zp"})
"""Control characters, lone surrogates, line and paragraph separators."""


def is_printable(text: str) -> bool:
    """Tell whether ``text`` is one line without control or reordering characters."""
    return not any(map(_harmful, text))


def harmless(text: str, keep: str = "\n\t") -> str:
    """Escape every character of ``text`` that a terminal would interpret, for example as ``\\x1b``.

    ``keep``: characters that are not escaped, such as line breaks and tabs of the caller's own
    text.
    """
    return "".join(
        _escape(letter) if letter not in keep and _harmful(letter) else letter for letter in text
    )


def one_line(text: str) -> str:
    """Return ``text`` from a file as one line, in which line breaks and tabs are escaped, too."""
    return harmless(text, keep="")


def time_left(seconds: float) -> str:
    """Format a remaining time as ``45 s``, ``3 min`` or ``1.5 h``; NaN or infinity gives ``?``."""
    if not math.isfinite(seconds):
        return "?"
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"


def _harmful(letter: str) -> bool:
    return letter in _REORDERING or unicodedata.category(letter) in _UNPRINTABLE


def _escape(letter: str) -> str:
    return letter.encode("unicode_escape").decode("ascii")
