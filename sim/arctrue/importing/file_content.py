"""The content of a file as a reader returns it: named columns of numbers or text."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.measurement import MeasurementError


@dataclass(frozen=True)
class Known:
    """A quantity that the format itself names: its column and unit."""

    column: str
    unit: str = ""


@dataclass(frozen=True)
class FileContent:
    """One file.

    ``columns``: arrays (rows,) of int64, float64 or text. ``lines``: the line of each row in the
    file; None if the file has no lines (rows then count from 1). ``known``: quantities that the
    format itself names (as a guide log does). ``notes``: decisions of the reader. ``table``,
    ``instrument``: what the file states about the table and the reference.
    """

    path: Path
    format: str
    columns: Mapping[str, NDArray[Any]]
    lines: NDArray[np.int64] | None = None
    known: Mapping[str, Known] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    instrument: str | None = None

    @property
    def rows(self) -> int:
        """Number of rows."""
        return next((column.size for column in self.columns.values()), 0)

    def first(self, rows: int) -> FileContent:
        """Give the same content with only the first ``rows`` rows."""
        lines = None if self.lines is None else self.lines[:rows]
        columns = {name: column[:rows] for name, column in self.columns.items()}
        return replace(self, columns=columns, lines=lines)

    def line(self, row: int) -> int:
        """Give the line number that people see for row 0, 1, …"""
        return row + 1 if self.lines is None else int(self.lines[row])

    def fault(self, message: str, row: int | None = None, column: str | None = None) -> Exception:
        """Make a MeasurementError that names the file and the place of ``row`` 0, 1, … in it."""
        place = None if row is None else self.line(row)
        return MeasurementError("value", self.path, message, row=place, column=column)
