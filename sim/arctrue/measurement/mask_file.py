"""Reads ``mask.csv``, which lists rows that the user masked and rows that must be used although
they look wrong."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal, TypeVar

import numpy as np

from arctrue.measurement.csv_blocks import CsvFile
from arctrue.measurement.errors import MeasurementError
from arctrue.measurement.measurement_set import Capture, Reference

FILE_NAME = "mask.csv"
Channel = TypeVar("Channel", Capture, Reference)


def with_mask_file(
    folder: Path,
    channel: Literal["capture", "reference"],
    recorded: Path,
    rows: Channel,
    warnings: list[str],
) -> Channel:
    """Apply ``folder``/mask.csv to the ``rows`` of the file ``recorded``; if mask.csv is missing,
    the rows remain unchanged.

    The file has the columns ``capture_row,mask`` or ``reference_row,mask``, or all three; a row
    number of 0 then means that the line names no row of that channel. A row is named by its line in
    the CSV file; the header is line 1. ``mask`` is 1 for a row that must not be used and 0 for a
    row that must be used. If the file has another column, a warning is added to ``warnings``, once
    for both channels. Raises MeasurementError for a faulty file. A blank line before a row of
    ``recorded`` is a fault, too, because all later rows would have two numbers: the line, and the
    number that the commands print.
    """
    path = folder / FILE_NAME
    if not path.is_file():
        return rows
    file = CsvFile(path, ("mask",), ("capture_row", "reference_row"))
    warnings.extend(warning for warning in file.warnings if warning not in warnings)
    column = f"{channel}_row"
    if len(file.columns) == 1:
        raise MeasurementError(
            "missing", path, "expected a column capture_row or reference_row", row=1
        )
    if column in file.columns and (blank := _blank_line(recorded)) is not None:
        raise MeasurementError(
            "format",
            recorded,
            f"is blank; remove the blank lines, because {FILE_NAME} names the rows by their lines",
            row=blank,
        )
    size = (rows.head1_counts if isinstance(rows, Capture) else rows.error_arcsec).size
    mask = np.zeros(size, dtype=bool) if rows.mask is None else rows.mask.copy()
    trusted = np.zeros(size, dtype=bool) if rows.trusted is None else rows.trusted.copy()
    done = 0
    for block in file.blocks():
        lines = block.get(column)
        if lines is None:
            return rows
        for line, value in zip(lines.tolist(), block["mask"].tolist(), strict=True):
            place = int(line) - 2
            if line == 0:
                pass
            elif line != int(line) or not 0 <= place < size:
                raise MeasurementError(
                    "value",
                    path,
                    f"expected a line of {channel}.csv from 2 to {size + 1}, found {line:g}",
                    row=file.row_of(done),
                    column=column,
                )
            elif value not in (0, 1):
                raise MeasurementError(
                    "value",
                    path,
                    f"expected 0 or 1, found {value}",
                    row=file.row_of(done),
                    column="mask",
                )
            else:
                mask[place], trusted[place] = value == 1, value == 0
            done += 1
    return replace(rows, mask=mask, trusted=trusted)


def _blank_line(path: Path) -> int | None:
    """Return the number of the first blank line that has a row after it, or None."""
    blank = None
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            if line.strip(b"\r\n"):
                if blank is not None:
                    return blank
            elif blank is None:
                blank = number
    return None
