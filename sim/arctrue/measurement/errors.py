"""Defines the error whose message describes a fault of a measurement set to the user."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

Fault = Literal["missing", "format", "value", "not_a_number", "empty", "time", "order"]
"""Kinds of a fault: missing (file, key or column), format (not TOML or CSV), value (wrong type or
range), not_a_number (NaN, infinite or an empty field), empty (no rows), time (the time decreases),
order (the rows of a run are not consecutive)."""


class MeasurementError(ValueError):
    """Is raised for a measurement set that cannot be used.

    ``row`` is a line number of the file as in an editor: the header is row 1. ``row`` and
    ``column`` are None if they do not apply to the fault.
    """

    def __init__(
        self,
        fault: Fault,
        file: Path,
        message: str,
        *,
        row: int | None = None,
        column: str | None = None,
    ) -> None:
        """Store file, row and column of the fault, and compose the message for the user."""
        place = str(file)
        if row is not None:
            place += f", row {row}"
        if column is not None:
            place += f", column {column}"
        super().__init__(f"{place}: {message}")
        self.fault: Fault = fault
        self.message = message
        self.file = file
        self.row = row
        self.column = column

    def of_file(self, file: Path) -> MeasurementError:
        """Return this error with another file name, for a fault in the copy of a packed file.

        Parameters
        ----------
        file : Path
            The file that the user knows.

        Returns
        -------
        MeasurementError
            The same fault with the name of ``file``.
        """
        return MeasurementError(self.fault, file, self.message, row=self.row, column=self.column)
