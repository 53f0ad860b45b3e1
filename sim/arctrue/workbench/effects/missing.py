"""Defines the data that a set lacks for the test of an effect, in words and by kind."""

from __future__ import annotations

from enum import Enum
from typing import Self

CAPTURE = "a capture of both heads"
_KEY = "the key "


class Lack(Enum):
    """Kind of data that a set lacks."""

    CAPTURE = "capture"
    """A capture of two heads, which the owner of a machine with one reading cannot record."""
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
    """Return the words for a lacking capture of two heads; ``instead``: data that would do as
    well."""
    what = f"{CAPTURE}, or {instead}" if instead else CAPTURE
    return Missing(what, Lack.CAPTURE, reason=reason)


def lacking_key(key: str, further: str = "") -> Missing:
    """Return the words for a lacking key; ``further``: data that the effect needs in addition."""
    return Missing(f"{_KEY}{key}, and {further}" if further else f"{_KEY}{key}", Lack.KEY)


def missing_of(item: str) -> Missing:
    """Return the kind of an entry.

    An own effect may return plain text; its beginning, as in the entries of this module, then
    states the kind.
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
