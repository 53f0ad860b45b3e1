"""Defines the data that a set lacks for the test of an effect, in words and by kind."""

from __future__ import annotations

from enum import Enum
from typing import Self

CAPTURE = "a capture of both heads"
_KEY = "the key "


class Lack(Enum):
    """Kind of data that a set lacks."""

    CAPTURE = "capture"
    """A capture of two heads, which a machine with a single head cannot record."""
    KEY = "key"
    """A key of the description, which is not a measurement."""
    MEASUREMENT = "measurement"
    """Any other data, which are measured."""


class Missing(str):
    """Words for the data that a set lacks; ``Effect.missing`` returns a list of them."""

    kind: Lack
    what: str
    """The words without the reason."""

    def __new__(cls, what: str, kind: Lack = Lack.MEASUREMENT, *, reason: str = "") -> Self:
        """Make the words: ``what``, and the reason after a colon."""
        made = super().__new__(cls, f"{what}: {reason}" if reason else what)
        made.kind, made.what = kind, what
        return made


def lacking_capture(reason: str = "", *, instead: str = "") -> Missing:
    """Return the words for a lacking capture of two heads; ``instead``: data that are also
    sufficient."""
    what = f"{CAPTURE}, or {instead}" if instead else CAPTURE
    return Missing(what, Lack.CAPTURE, reason=reason)


def lacking_key(key: str, further: str = "") -> Missing:
    """Return the words for a lacking key; ``further``: data that the effect needs in addition."""
    return Missing(f"{_KEY}{key}, and {further}" if further else f"{_KEY}{key}", Lack.KEY)


def missing_of(item: str) -> Missing:
    """Return an entry of ``Effect.missing`` with its kind.

    A user's effect may return plain text. Its first words then show the kind, if they are those of
    :func:`lacking_capture` or :func:`lacking_key`.
    """
    if isinstance(item, Missing):
        return item
    what, _, reason = item.partition(": ")
    kind = Lack.MEASUREMENT
    if item.startswith(CAPTURE):
        kind = Lack.CAPTURE
    elif item.startswith(_KEY):
        kind = Lack.KEY
    return Missing(what, kind, reason=reason)
