"""Defines the content of a file as a reader returns it: named columns of numbers or text."""

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
    """The column and unit of a quantity, if the file format itself defines them."""

    column: str
    unit: str = ""


@dataclass(frozen=True)
class FileContent:
    """Holds the content of one file as a reader returns it.

    Parameters
    ----------
    path : Path
        The file.
    format : str
        Name of its format.
    columns : mapping of str to ndarray, shape (rows,)
        Columns of int64, float64 or text by name, in the file's own units.
    lines : ndarray of int, shape (rows,), optional
        Line number of each row in the file; without it rows are numbered from 1.
    known : mapping of str to Known, optional
        Quantities that the format itself names, with column and unit.
    notes : tuple of str, optional
        Decisions of the reader, one sentence each.
    instrument : str, optional
        Reference instrument that the file names.
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
        """Return the content with only the first ``rows`` rows.

        Parameters
        ----------
        rows : int
            Number of rows.

        Returns
        -------
        FileContent
            The same columns, shorter.
        """
        lines = None if self.lines is None else self.lines[:rows]
        columns = {name: column[:rows] for name, column in self.columns.items()}
        return replace(self, columns=columns, lines=lines)

    def line(self, row: int) -> int:
        """Return the number of a row for messages to the user.

        Parameters
        ----------
        row : int
            Index of the row, from 0.

        Returns
        -------
        int
            Line of the row in the file, or number of the row from 1.
        """
        return row + 1 if self.lines is None else int(self.lines[row])

    def fault(self, message: str, row: int | None = None, column: str | None = None) -> Exception:
        """Return an error whose message names file, row and column.

        Parameters
        ----------
        message : str
            Text that states the expected and the found content, and the remedy.
        row : int, optional
            Index of the row, from 0.
        column : str, optional
            The column's name in the file.

        Returns
        -------
        Exception
            A MeasurementError that the caller raises.
        """
        place = None if row is None else self.line(row)
        return MeasurementError("value", self.path, message, row=place, column=column)
