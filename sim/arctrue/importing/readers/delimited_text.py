"""Text in columns: commas, semicolons, tabs or spaces; decimal point or decimal comma."""

from __future__ import annotations

import csv
import itertools
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.importing.choices import Ambiguous, Choices
from arctrue.importing.reader import ReadSettings
from arctrue.importing.recording import Recording
from arctrue.measurement import MeasurementError

DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "space": None}
COMMENT = ("#", "%", "//")
LOOKED_AT = 400
"""Lines that decide how the file is written."""
_POINT = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?\Z")
_COMMA = re.compile(r"[+-]?(\d+,?\d*|,\d+)([eEdD][+-]?\d+)?\Z")
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(,\d{3})+(\.\d*)?\Z")
_MISSING = ("", "nan", "na", "n/a", "null", "none", "--")


@dataclass(frozen=True)
class _Form:
    """How a file is written."""

    delimiter: str
    decimal: str

    def split(self, line: str) -> list[str]:
        sign = DELIMITERS[self.delimiter]
        if sign is None:
            return line.split()
        if '"' in line:
            return [field.strip() for field in next(csv.reader([line], delimiter=sign))]
        return [field.strip() for field in line.split(sign)]

    def is_number(self, text: str) -> bool:
        if self.decimal == "comma":
            return bool(_COMMA.match(text))
        return bool(_POINT.match(text) or (self.delimiter != "comma" and _THOUSANDS.match(text)))

    def with_point(self, text: str) -> str:
        """The number as Python writes it."""
        return text.replace(",", "." if self.decimal == "comma" else "")


def recognises(path: Path, head: bytes) -> bool:
    """True for text."""
    return b"\0" not in head


def read(path: Path, settings: ReadSettings, choices: Choices) -> Recording:
    """Columns with the names of the header; ``1``, ``2`` … where there is none.

    Lines that begin with #, % or // are comments; the last one before the rows is the header if it
    has as many words as they have fields. A column is of text where a field of it is no number.
    Raises MeasurementError naming row and column, AmbiguousError where two readings are possible.
    """
    lines = list(_lines(path))
    form = _form(path, [text for _, text in lines[:LOOKED_AT]], settings, choices)
    first = _first_row(lines, form)
    if first is None:
        raise MeasurementError("format", path, "no line of numbers was found")
    fields = form.split(lines[first][1])
    names = _header(lines, first, len(fields), form)
    rows, places = [], []
    for line, text in lines[first:]:
        if text.startswith(COMMENT):
            continue
        row = form.split(text)
        if len(row) != len(names):
            raise MeasurementError(
                "format", path, f"expected {len(names)} fields, found {len(row)}", row=line
            )
        rows.append(row)
        places.append(line)
    columns: dict[str, NDArray[Any]] = {
        name: _column(values, form)
        for name, values in zip(names, zip(*rows, strict=True), strict=True)
    }
    told = f"{path.name}: {len(rows)} rows of {len(names)} columns, {form.delimiter} between them"
    if form.decimal == "comma":
        told += ", decimal comma"
    return Recording(path, "text", columns, np.array(places), notes=(told,))


def _lines(path: Path) -> Iterator[tuple[int, str]]:
    try:
        with path.open(encoding="utf-8-sig") as file:
            for number, text in enumerate(file, start=1):
                stripped = text.strip("\r\n ")
                if stripped.strip():
                    yield number, stripped
    except UnicodeDecodeError as error:
        raise MeasurementError(
            "format", path, "is not text in UTF-8 (and no format that a reader recognises)"
        ) from error


def _form(path: Path, lines: Sequence[str], settings: ReadSettings, choices: Choices) -> _Form:
    """The one form in which the file has rows of numbers; asked where several do."""
    for value, known, option in (
        (settings.delimiter, [*DELIMITERS], "--delimiter"),
        (settings.decimal, ["point", "comma"], "--decimal"),
    ):
        if value and value not in known:
            raise ValueError(f"{option} {value}: expected one of {', '.join(known)}")
    delimiters = [settings.delimiter] if settings.delimiter else [*DELIMITERS]
    decimals = [settings.decimal] if settings.decimal else ["point", "comma"]
    data = [text for text in lines if not text.startswith(COMMENT)]
    forms: dict[_Form, tuple[int, int]] = {}
    for delimiter, decimal in itertools.product(delimiters, decimals):
        if delimiter == "comma" and decimal == "comma":
            continue
        form = _Form(delimiter, decimal)
        score = _score(form, data)
        if score is not None:
            forms[form] = score
    if not forms:
        raise MeasurementError(
            "format",
            path,
            "no rows of numbers were found, with commas, semicolons, tabs or spaces between them",
        )
    most = max(forms.values())
    best = [form for form, score in forms.items() if score == most]
    by_delimiter = list(dict.fromkeys(form.delimiter for form in best))
    alike = all(best[0].split(text) == form.split(text) for form in best[1:] for text in data)
    if len(by_delimiter) > 1 and not alike:
        given = choices.ask(
            Ambiguous("--delimiter", f"{path}: could be divided in several ways.", [*by_delimiter])
        )
        best = [form for form in best if form.delimiter == given]
    if len(best) > 1 and any(_has_comma(form, data) for form in best):
        given = choices.ask(
            Ambiguous("--decimal", f"{path}: a comma in a number.", ["point", "comma"])
        )
        best = [form for form in best if form.decimal == given]
    return best[0]


def _has_comma(form: _Form, data: Sequence[str]) -> bool:
    return form.delimiter != "comma" and any("," in text for text in data)


def _score(form: _Form, data: Sequence[str]) -> tuple[int, int] | None:
    """Numbers less other fields in the lines of one width, and those lines; None: no numbers."""
    widths: dict[int, int] = {}
    numbers: dict[int, int] = {}
    for text in data:
        fields = form.split(text)
        count = sum(map(form.is_number, fields))
        if count:
            widths[len(fields)] = widths.get(len(fields), 0) + 1
            # In "1,5;2,5" commas would leave a field that is no number; it counts against them.
            numbers[len(fields)] = numbers.get(len(fields), 0) + 2 * count - len(fields)
    if not widths:
        return None
    width = max(widths, key=lambda key: (numbers[key], key))
    return numbers[width], widths[width]


def _first_row(lines: Sequence[tuple[int, str]], form: _Form) -> int | None:
    """The first line that looks like most rows: as many fields, the same ones numbers."""
    shapes: dict[tuple[int, int], int] = {}
    found: dict[tuple[int, int], int] = {}
    for index, (_, text) in enumerate(lines[:LOOKED_AT]):
        if text.startswith(COMMENT):
            continue
        fields = form.split(text)
        shape = (len(fields), sum(map(form.is_number, fields)))
        if shape[1] == 0:
            continue
        shapes[shape] = shapes.get(shape, 0) + 1
        found.setdefault(shape, index)
    if not shapes:
        return None
    width, _ = max(shapes, key=lambda shape: shapes[shape])
    return min(index for shape, index in found.items() if shape[0] == width)


def _header(lines: Sequence[tuple[int, str]], first: int, width: int, form: _Form) -> list[str]:
    """The names on the line before the rows; numbers where that is no header."""
    if first:
        text = lines[first - 1][1]
        stripped = text.lstrip("#%/ ")
        names = [name.strip() for name in form.split(stripped)]
        for split in (names, stripped.split()):
            if len(split) == width and len(set(split)) == width and all(split):
                return split
    return [str(number) for number in range(1, width + 1)]


def _column(texts: Sequence[str], form: _Form) -> NDArray[Any]:
    """Whole numbers, numbers with NaN for what is missing, or text."""
    cleaned = [form.with_point(text) for text in texts]
    whole = all(text.lstrip("+-").isdecimal() and text.isascii() for text in texts)
    if whole:
        try:
            return np.array([int(text) for text in texts], dtype=np.int64)
        except OverflowError:
            return np.array(texts)
    if all(form.is_number(text) or text.lower() in _MISSING for text in texts):
        return np.array(
            [
                np.nan if text.lower() in _MISSING else float(text.lower().replace("d", "e"))
                for text in cleaned
            ]
        )
    return np.array(texts)
