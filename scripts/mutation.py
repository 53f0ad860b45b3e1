"""Defines a mutation: one deliberate error in one file."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Mutation:
    """Mutation: a wrong text for a file, and the pytest test that must fail because of this text.

    ``old`` occurs exactly once in ``file``. A mutation belongs in a list if a person could make
    this error and no other test would fail at once.
    """

    name: str
    fault: str
    file: str
    old: str
    new: str
    test: str
