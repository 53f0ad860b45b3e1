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
    """Content of one file as a reader returns it.

    Parameters
    ----------
    path : Path
        The file.
    format : str
        Name of its format.
    columns : mapping of str to ndarray, shape (rows,)
        Of int64, float64 or text, in the file's own units.
    lines : ndarray of int, shape (rows,), optional
        The line of each row in the file; without it the first row is row 1.
    known : mapping of str to Known, optional
        Quantities that the format itself names, with column and unit.
    notes : tuple of str, optional
        What the reader decided, one sentence each.
    instrument : str, optional
        What the file says of the reference.
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
        """Take the first rows.

        Parameters
        ----------
        rows : int
            How many.

        Returns
        -------
        FileContent
            The same columns, shorter.
        """
        lines = None if self.lines is None else self.lines[:rows]
        columns = {name: column[:rows] for name, column in self.columns.items()}
        return replace(self, columns=columns, lines=lines)

    def line(self, row: int) -> int:
        """Tell the place of a row for people.

        Parameters
        ----------
        row : int
            0, 1, ….

        Returns
        -------
        int
            Its line in the file, or its number from 1.
        """
        return row + 1 if self.lines is None else int(self.lines[row])

    def fault(self, message: str, row: int | None = None, column: str | None = None) -> Exception:
        """Make the error of a place in the file.

        Parameters
        ----------
        message : str
            What was expected, what was found, what to do.
        row : int, optional
            0, 1, ….
        column : str, optional
            The column's name in the file.

        Returns
        -------
        Exception
            A MeasurementError, to be raised.
        """
        place = None if row is None else self.line(row)
        return MeasurementError("value", self.path, message, row=place, column=column)
