"""Defines the accesses of the processor's bus master and the answers to them.

``scripts/bitstream_models/axi_master.h`` carries out a list of accesses.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Final

WORD: Final = 0xFFFF_FFFF
BEAT_STEP: Final = 0x0100_0193
"""Difference between the data of two successive beats of a write, the same as in axi_master.h."""


class Burst(IntEnum):
    """Kinds of burst: values of AxBURST in AXI3."""

    FIXED = 0
    INCREASING = 1
    WRAPPING = 2
    RESERVED = 3


class Response(IntEnum):
    """Kinds of answer: values of BRESP and RRESP in AXI3."""

    OKAY = 0
    EXCLUSIVE = 1
    SLAVE_ERROR = 2
    DECODE_ERROR = 3


@dataclass(frozen=True)
class Access:
    """Access of the bus master, a pause, or a reset.

    ``kind`` is w for a write, r for a read, n for a pause, z for a reset; a pause or reset lasts
    ``data`` clocks.
    """

    kind: str
    address: int = 0
    data: int = 0
    beats: int = 1
    size: int = 2
    burst: Burst = Burst.INCREASING
    strobe: int = 0xF
    last: int | None = None
    """Beat at which WLAST is high; None: the last beat."""
    together: bool = False
    """Whether the access may start while an access in the other direction (read or write) is not
    yet finished."""

    def line(self) -> str:
        """Return the access as a line in the form that the bench reads."""
        last = self.beats - 1 if self.last is None else self.last
        return (
            f"{self.kind} {self.address:x} {self.data:x} {self.beats} {self.size} "
            f"{self.burst.value} {self.strobe} {last} {int(self.together)}"
        )

    def beat(self, place: int) -> int:
        """Return the data of one beat of a write; ``place`` is the number of the beat, from 0."""
        return (self.data + place * BEAT_STEP) & WORD


@dataclass(frozen=True)
class Answer:
    """Answer to the access with the index ``place`` in the list. A write has one answer; a read has
    one answer for each beat."""

    place: int
    response: Response
    data: int


def read_answers(path: Path) -> list[Answer]:
    """Return the answers that the bench wrote, in the order in which it received them."""
    found = []
    for line in path.read_text(encoding="ascii").splitlines():
        place, response, data = line.split()
        found.append(Answer(int(place), Response(int(response)), int(data, 16)))
    return found
