"""Defines the rows of a bench, which compare repeated measurements and their spread with a peer
(another program for the same task) or with a limit.

A bench writes its rows with ``--rows FILE``, and ``scripts.bench_page`` makes one page from the
rows of all benches.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from arctrue.base.typed_content import read_json
from arctrue.base.whole_file import write_whole_text

HEADINGS = ("", "Unit", "Median", "Quartiles", "Least to most", "Runs", "Peer or limit")


@dataclass(frozen=True, slots=True)
class Row:
    """Row of a bench: one measured quantity."""

    what: str
    unit: str
    values: tuple[float, ...]
    """Results of all runs; only one result if the quantity is a count or a sum that is equal in
    every run."""
    remark: str
    """Text with the value of the peer, or with the limit."""
    kept: bool = True
    """Whether the value is within the limit; True if there is no limit."""

    @property
    def median(self) -> float:
        """Return the median of the runs."""
        return float(np.median(self.values))

    def cells(self) -> list[str]:
        """Return the cells of the row in a table with ``HEADINGS``."""
        remark = self.remark if self.kept else f"**{self.remark}: not kept**"
        if len(self.values) == 1:
            return [self.what, self.unit, shown(self.median), "", "", "counted", remark]
        low, high = np.quantile(self.values, (0.25, 0.75))
        return [
            self.what,
            self.unit,
            shown(self.median),
            f"{shown(low)} to {shown(high)}",
            f"{shown(min(self.values))} to {shown(max(self.values))}",
            str(len(self.values)),
            remark,
        ]


def shown(value: float) -> str:
    """Format a number with three digits and thousands separators."""
    if abs(value) >= 1000:
        digits = 2 - int(np.floor(np.log10(abs(value))))
        return f"{round(value, digits):,.0f}"
    return f"{value:.3g}"


def table(rows: Sequence[Row]) -> list[str]:
    """Return the rows as lines of Markdown."""
    lines = [f"| {' | '.join(HEADINGS)} |", "|---|---|---:|---:|---:|---:|---|"]
    return lines + [f"| {' | '.join(row.cells())} |" for row in rows]


def add_option(parser: argparse.ArgumentParser) -> None:
    """Add the option ``--rows FILE``."""
    parser.add_argument("--rows", type=Path, metavar="FILE", help="write the rows as JSON")


def give_out(rows: Sequence[Row], file: Path | None) -> int:
    """Print the rows and, if a file is named, write the rows to it. Return 1 if a row exceeds its
    limit."""
    print("\n".join(table(rows)))
    if file is not None:
        write_whole_text(file, json.dumps([asdict(row) for row in rows], indent=1) + "\n")
    return int(not all(row.kept for row in rows))


def read_rows(file: Path) -> list[Row]:
    """Read rows that :func:`give_out` wrote."""
    return read_json(file, list[Row])
