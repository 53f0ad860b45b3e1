"""What a reader makes of a file: named columns of numbers or text."""

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
    """What a format says of a column: its name there and its unit."""

    column: str
    unit: str = ""


@dataclass(frozen=True)
class FileContent:
    """One file.

    ``columns``: arrays (rows,), of int64, float64 or text. ``lines``: the line of each row in the
    file, None where the file has no lines (row 1 is then the first). ``known``: quantities that the
    format itself names (a guide log, say). ``notes``: what the reader decided. ``table``,
    ``instrument``: what the file says of the table and of the reference.
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
        """How many rows it has."""
        return next((column.size for column in self.columns.values()), 0)

    def first(self, rows: int) -> FileContent:
        """The same with only the first ``rows`` rows."""
        lines = None if self.lines is None else self.lines[:rows]
        columns = {name: column[:rows] for name, column in self.columns.items()}
        return replace(self, columns=columns, lines=lines)

    def line(self, row: int) -> int:
        """The place of row 0, 1, … for people."""
        return row + 1 if self.lines is None else int(self.lines[row])

    def fault(self, message: str, row: int | None = None, column: str | None = None) -> Exception:
        """A MeasurementError with the file, and the place of ``row`` 0, 1, … in it."""
        place = None if row is None else self.line(row)
        return MeasurementError("value", self.path, message, row=place, column=column)
