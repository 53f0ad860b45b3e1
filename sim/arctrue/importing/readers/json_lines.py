"""Reads files of JSON lines: each line is one object or one list."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.importing.choices import Choices
from arctrue.importing.file_content import FileContent
from arctrue.importing.reader import ReadSettings
from arctrue.importing.readers.unpacked_size import refuse_many_fields
from arctrue.measurement import MeasurementError


def recognises(path: Path, head: bytes) -> bool:
    """Tell whether the first line is a JSON object or list."""
    first = head.lstrip(b"\xef\xbb\xbf \t\r\n").split(b"\n", 1)[0].strip()
    if first[:1] not in (b"{", b"["):
        return False
    try:
        return isinstance(json.loads(first), dict | list)
    except (ValueError, RecursionError):
        return False


def read(path: Path, settings: ReadSettings, choices: Choices) -> FileContent:
    """Return one column per key, or the columns ``1``, ``2`` … for lists; an absent key is a
    missing value.

    Raises MeasurementError; for a wrong line it names the row.
    """
    rows: list[dict[str, Any]] = []
    places = []
    fields = 0
    try:
        with path.open(encoding="utf-8-sig") as file:
            for number, text in enumerate(file, start=1):
                if text.strip():
                    rows.append(_row(path, number, text))
                    fields += 1 + len(rows[-1])
                    refuse_many_fields(path, fields)
                    places.append(number)
    except UnicodeDecodeError as error:
        raise MeasurementError("format", path, "is not text in UTF-8") from error
    names = list(dict.fromkeys(name for row in rows for name in row))
    columns = {name: _column([row.get(name) for row in rows]) for name in names}
    note = f"{path.name}: {len(rows)} lines of JSON with {len(names)} keys"
    return FileContent(path, "json", columns, np.array(places), notes=(note,))


def _row(path: Path, number: int, text: str) -> dict[str, Any]:
    try:
        row = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise MeasurementError("format", path, f"is not JSON: {error}", row=number) from error
    if isinstance(row, list):
        row = {str(place): value for place, value in enumerate(row, start=1)}
    if not isinstance(row, dict):
        raise MeasurementError("format", path, "expected an object or a list", row=number)
    for name, value in row.items():
        if isinstance(value, dict | list):
            raise MeasurementError(
                "value", path, "expected a number or a text", row=number, column=name
            )
    return row


def _column(values: list[Any]) -> NDArray[Any]:
    if all(isinstance(value, int) for value in values):
        try:
            return np.array(values, dtype=np.int64)
        except OverflowError:
            return np.array([str(value) for value in values])
    if all(value is None or isinstance(value, int | float) for value in values):
        return np.array([np.nan if value is None else float(value) for value in values])
    return np.array(["" if value is None else str(value) for value in values])
