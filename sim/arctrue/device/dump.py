"""Reads a capture that a device sends row by row; each line has a CRC-32 over its numbers.

The CRC covers the numbers of a line as little-endian words, in the order of the line;
:func:`read_head` names the numbers of the head line.
"""

from __future__ import annotations

import re
import struct
import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.measurement import Capture, MeasurementSet, Table
from arctrue.measurement.measurement_set import FURTHER_HEADS

NO_TEMPERATURE = 0x8000_0000
_ROW = re.compile(r"(\d{1,6})((?:,-?\d{1,19}){2,4}),([0-9A-F]{8})")
_HEAD = re.compile(
    r"dump sequence=(?P<sequence>\d+) samples=(?P<samples>\d+) "
    r"counts_per_rev=(?P<counts_per_rev>\d+) clock_hz=(?P<clock_hz>\d+) "
    r"period_clocks=(?P<period_clocks>\d+) start_time=(?P<start_time>\d+) "
    r"separation_deg=(?P<separation_deg>-?\d+\.\d{6})"
    r"(?: temperature_c=(?P<temperature_c>-?\d+\.\d\d))? crc=(?P<crc>[0-9A-F]{8})"
)


@dataclass(frozen=True, slots=True)
class DumpHead:
    """Head line of a dump: values that are valid for all rows."""

    sequence: int
    samples: int
    counts_per_rev: int
    clock_hz: int
    period_clocks: int
    start_time: int
    """Time stamp of the first sample, clocks of the gateware."""
    separation_deg: float
    temperature_c: float | None
    """Temperature of the chip; None if the device sent no temperature."""

    def missing(self, rows: dict[int, tuple[int, ...]]) -> list[tuple[int, int]]:
        """Return, for each gap of missing rows, its first row and its number of rows."""
        there = np.zeros(self.samples + 2, dtype=bool)
        there[[0, -1]] = True
        there[[row + 1 for row in rows if row < self.samples]] = True
        edges = np.flatnonzero(np.diff(there.astype(np.int8)))
        return [
            (int(begin), int(end - begin))
            for begin, end in zip(edges[0::2], edges[1::2], strict=True)
        ]

    def measurement(self, rows: dict[int, tuple[int, ...]], port: str) -> MeasurementSet:
        """Return all rows as a measurement set; the places of heads 3 and 4 are computed from their
        readings.

        Raises ValueError if rows differ in their number of heads.
        """
        heads = {len(row) for row in rows.values()}
        if len(heads) != 1:
            raise ValueError(f"rows have {sorted(heads)} heads; expected one number for all rows")
        counts = np.array([rows[row] for row in range(self.samples)], dtype=np.int64)
        further = dict(zip(FURTHER_HEADS, counts.T[2:], strict=False))
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
            **further,
            clock_hz=float(self.clock_hz),
            temperature_c=None if temperature is None else np.full(self.samples, temperature),
        )
        table = Table(counts_per_rev=self.counts_per_rev, head_separation_deg=self.separation_deg)
        if further:
            table = Table(
                counts_per_rev=self.counts_per_rev,
                head_separation_deg=self.separation_deg,
                head_places_deg=(0.0, self.separation_deg, *self._further_places(counts)),
            )
        return MeasurementSet(table, capture, title=title)

    def _further_places(self, counts: NDArray[np.int64]) -> list[float]:
        """Return the places of heads 3 and 4, degrees: their mean readings relative to head 1."""
        apart = (counts[:, 2:] - counts[:, :1]).mean(axis=0) / self.counts_per_rev * 360.0
        return [round(float(place), 6) for place in apart % 360.0]


def read_head(line: str) -> DumpHead | None:
    """Return the head line of a dump; None for any other line, or if a character was changed."""
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


def read_row(line: str) -> tuple[int, ...] | None:
    """Return a row's number and the counts of its two to four heads; None if the line is not a row
    or was changed."""
    found = _ROW.fullmatch(line)
    if found is None:
        return None
    row, counts = int(found[1]), [int(word) for word in found[2].split(",")[1:]]
    try:
        words = struct.pack(f"<I{len(counts)}q", row, *counts)
    except struct.error:
        return None
    return (row, *counts) if zlib.crc32(words) == int(found[3], 16) else None
