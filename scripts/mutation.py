"""One way to break a file on purpose."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Mutation:
    """One wrong text in one file, and the pytest test that fails because of it.

    ``old`` stands exactly once in ``file``. A mutation is worth its place when it is a slip that a
    person could make and that another test would not show at once.
    """

    name: str
    fault: str
    file: str
    old: str
    new: str
    test: str
