"""A capture that a device tells row by row, each line with a CRC-32 over its numbers.

The numbers of a line, as little-endian words in the order of the line, give its CRC; those of the
head are named in :func:`read_head`.
"""

from __future__ import annotations

import re
import struct
import zlib
from dataclasses import dataclass

import numpy as np

from arctrue.measurement import Capture, MeasurementSet, Table

NO_TEMPERATURE = 0x8000_0000
_ROW = re.compile(r"(\d{1,6}),(-?\d{1,19}),(-?\d{1,19}),([0-9A-F]{8})")
_HEAD = re.compile(
    r"dump sequence=(?P<sequence>\d+) samples=(?P<samples>\d+) "
    r"counts_per_rev=(?P<counts_per_rev>\d+) clock_hz=(?P<clock_hz>\d+) "
    r"period_clocks=(?P<period_clocks>\d+) start_time=(?P<start_time>\d+) "
    r"separation_deg=(?P<separation_deg>-?\d+\.\d{6})"
    r"(?: temperature_c=(?P<temperature_c>-?\d+\.\d\d))? crc=(?P<crc>[0-9A-F]{8})"
)


@dataclass(frozen=True, slots=True)
class DumpHead:
    """What holds for all rows."""

    sequence: int
    samples: int
    counts_per_rev: int
    clock_hz: int
    period_clocks: int
    start_time: int
    """Clocks."""
    separation_deg: float
    temperature_c: float | None
    """Of the die; None where the device has told none."""

    def missing(self, rows: dict[int, tuple[int, int]]) -> list[tuple[int, int]]:
        """First row and number of rows of each gap."""
        there = np.zeros(self.samples + 2, dtype=bool)
        there[[0, -1]] = True
        there[[row + 1 for row in rows if row < self.samples]] = True
        edges = np.flatnonzero(np.diff(there.astype(np.int8)))
        return [
            (int(begin), int(end - begin))
            for begin, end in zip(edges[0::2], edges[1::2], strict=True)
        ]

    def measurement(self, rows: dict[int, tuple[int, int]], port: str) -> MeasurementSet:
        """All rows as a set."""
        counts = np.array([rows[row] for row in range(self.samples)], dtype=np.int64)
        clocks = self.start_time + self.period_clocks * np.arange(self.samples)
        temperature = self.temperature_c
        title = f"capture {self.sequence} of {port}"
        if temperature is not None:
            title += ", temperature of the die"
        capture = Capture(
            run=np.zeros(self.samples, dtype=np.int64),
            time_s=clocks / self.clock_hz,
            head1_counts=counts[:, 0],
            head2_counts=counts[:, 1],
            clock_hz=float(self.clock_hz),
            temperature_c=None if temperature is None else np.full(self.samples, temperature),
        )
        table = Table(counts_per_rev=self.counts_per_rev, head_separation_deg=self.separation_deg)
        return MeasurementSet(table, capture, title=title)


def read_head(line: str) -> DumpHead | None:
    """None where a character of it was changed."""
    found = _HEAD.fullmatch(line)
    if found is None:
        return None
    celsius = found["temperature_c"]
    head = DumpHead(
        int(found["sequence"]),
        int(found["samples"]),
        int(found["counts_per_rev"]),
        int(found["clock_hz"]),
        int(found["period_clocks"]),
        int(found["start_time"]),
        float(found["separation_deg"]),
        None if celsius is None else float(celsius),
    )
    try:
        words = struct.pack(
            "<5IQiI",
            *(head.sequence, head.samples, head.counts_per_rev, head.clock_hz, head.period_clocks),
            head.start_time,
            round(head.separation_deg * 1e6),
            NO_TEMPERATURE
            if head.temperature_c is None
            else round(head.temperature_c * 100) & 0xFFFF_FFFF,
        )
    except struct.error:
        return None
    return head if zlib.crc32(words) == int(found["crc"], 16) and head.samples > 0 else None


def read_row(line: str) -> tuple[int, int, int] | None:
    """Number and counts of both heads; None where it is no row, or one that was changed."""
    found = _ROW.fullmatch(line)
    if found is None:
        return None
    row, head1, head2 = (int(found[place]) for place in (1, 2, 3))
    try:
        words = struct.pack("<Iqq", row, head1, head2)
    except struct.error:
        return None
    return (row, head1, head2) if zlib.crc32(words) == int(found[4], 16) else None
