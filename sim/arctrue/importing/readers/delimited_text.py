"""Reads text files with columns, separated by commas, semicolons, tabs or spaces, with decimal
point or comma."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from arctrue.importing.choices import Choices
from arctrue.importing.file_content import FileContent
from arctrue.importing.quantities import any_unit
from arctrue.importing.reader import ReadSettings
from arctrue.importing.readers.text_columns import TextColumns
from arctrue.importing.readers.text_form import COMMENT, RowShape, form_of, row_shape
from arctrue.importing.readers.text_lines import TextLines, encoding_of
from arctrue.measurement import MeasurementError

LOOKED_AT = 400
"""Number of lines from which the form of the table is determined."""
BLOCK_LINES = 1 << 16
_RULER = re.compile(r"[-=_+|*.,;\s]+\Z")
"""Pattern of a line of separators only: ------ or ;;;"""
_SHOWN = 60

Line = tuple[int, str]


def recognises(path: Path, head: bytes) -> bool:
    """Tell whether the file may be text: its first bytes contain no zero byte."""
    return b"\0" not in head


def read(path: Path, settings: ReadSettings, choices: Choices) -> FileContent:
    """Return the columns under the names of the header; without a header they are named ``1``,
    ``2`` …

    Lines that begin with #, % or // are comments. The last line above the rows, even a comment, is
    the header if it has as many words as the rows have fields. A row of units under the header is
    added to the names. Lines of words after the last row, repeated headers, and a last line that is
    cut off are left out, with a note. A column with a field that is not a number becomes a text
    column.

    If two interpretations are possible, the user chooses one. Raises MeasurementError, which names
    the row of a wrong line, and AmbiguousError if nobody answers.
    """
    encoding = encoding_of(path)
    source = TextLines(path, encoding)
    lines = iter(source)
    head = list(itertools.islice(lines, LOOKED_AT))
    form = form_of(path, [text for _, text in head], settings, choices)
    shape = row_shape([text for _, text in head], form)
    if shape is None:
        raise MeasurementError("format", path, "no line of numbers was found")
    first = next(i for i, (_, text) in enumerate(head) if _is_row(text, shape))
    names, header_notes = _header(path, head[:first], shape)
    rows = _Rows(path, shape, {text for _, text in head[:first]})
    body = itertools.chain(head[first:], lines)
    while block := list(itertools.islice(body, BLOCK_LINES)):
        rows.add(block)
    places = rows.finish(ended=source.ended)
    columns = dict(zip(names, rows.columns.finished(), strict=True))
    said = f"{path.name}: {places.size} rows, {len(names)} columns, separator {form.delimiter}"
    if form.decimal == "comma":
        said += ", decimal comma"
    notes = [said, encoding.note, *header_notes, *rows.notes]
    return FileContent(path, "text", columns, places, notes=tuple(filter(None, notes)))


def _is_row(text: str, shape: RowShape) -> bool:
    if text.startswith(COMMENT):
        return False
    fields = shape.form.split(text)
    return (
        len(fields) == shape.width
        and not shape.is_words(fields)
        and any(map(shape.form.weight, fields))
    )


@dataclass
class _Rows:
    """Collects the rows of a table; lines of words are held back until a later line shows whether
    the table continues."""

    path: Path
    shape: RowShape
    above: set[str]
    """Lines above the rows; if one of them occurs again, a second log was appended to the file."""
    notes: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.columns = TextColumns(self.path, self.shape.form, self.shape.width)
        self._places: list[NDArray[np.int64]] = []
        self._back: list[Line] = []
        self._repeated: list[int] = []

    def add(self, block: Sequence[Line]) -> None:
        """Add those lines of the block that are rows. Raises MeasurementError for a line with a
        wrong number of fields."""
        lines = [line for line in block if not line[1].startswith(COMMENT)]
        if not lines:
            return
        texts = [text for _, text in lines]
        fields = None if self._back else self.columns.fields(texts)
        if fields is None or not self._plain(fields):
            lines = list(self._rows_among(lines))
            if not lines:
                return
            fields = self.columns.fields([text for _, text in lines])
            assert fields is not None
        self.columns.add(fields)
        self._places.append(np.array([line for line, _ in lines], dtype=np.int64))

    def _plain(self, fields: Sequence[Iterable[object]]) -> bool:
        """Tell whether the first numeric column has a number in every line of the block."""
        form = self.shape.form
        return all(form.weight(str(text)) for text in fields[min(self.shape.numeric)])

    def _rows_among(self, lines: Sequence[Line]) -> Iterable[Line]:
        for line, text in lines:
            if text in self.above:
                self._repeated.append(line)
                continue
            fields = self.shape.form.split(text)
            if self.shape.is_words(fields):
                self._back.append((line, text))
                continue
            if len(fields) != self.shape.width:
                # A line with a wrong number of fields is held back, because it may be a last line
                # that was cut off.
                self._back.append((line, text))
                continue
            yield from self._kept_back()
            yield line, text

    def _kept_back(self) -> Iterable[Line]:
        """Yield the lines that were held back, because a row follows them. Raises MeasurementError
        if one of them is not a row."""
        for line, text in self._back:
            self._refuse_other_width(line, text)
            yield line, text
        self._back = []

    def _refuse_other_width(self, line: int, text: str) -> None:
        found = len(self.shape.form.split(text))
        if found == self.shape.width:
            return
        more = ""
        if self.shape.is_words(self.shape.form.split(text)):
            more = f": {_shown(text)}; put # before a line of words, or divide the file here"
        raise MeasurementError(
            "format",
            self.path,
            f"expected {self.shape.width} fields, found {found}{more}",
            row=line,
        )

    def finish(self, *, ended: bool) -> NDArray[np.int64]:
        """Return the line number of each row; add a note about lines after the last row."""
        name = self.path.name
        if self._back and not ended:
            line, text = self._back[-1]
            if not self.shape.is_words(self.shape.form.split(text)):
                del self._back[-1]
                self.notes.append(
                    f"{name}: the last line, row {line}, is cut off ({_shown(text)}) and left out"
                )
        for line, text in self._back:
            if not self.shape.is_words(self.shape.form.split(text)):
                self._refuse_other_width(line, text)
        if self._back:
            line, text = self._back[0]
            count = f"{len(self._back)} lines" if len(self._back) > 1 else "a line"
            self.notes.append(
                f"{name}: {count} of words after the last row, from row {line} on "
                f"({_shown(text)}), left out"
            )
        if self._repeated:
            self.notes.append(
                f"{name}: the lines above the rows are repeated, first at row {self._repeated[0]}; "
                "left out"
            )
        return np.concatenate(self._places)


def _shown(text: str) -> str:
    return repr(text if len(text) <= _SHOWN else text[:_SHOWN] + "…")


def _header(path: Path, above: Sequence[Line], shape: RowShape) -> tuple[list[str], list[str]]:
    """Return the columns' names (numbers if the file has no names) and the notes about them."""
    numbers = [str(number) for number in range(1, shape.width + 1)]
    lines = [(line, text) for line, text in above if not _RULER.match(text)]
    if not lines:
        return numbers, []
    names = _words(lines[-1][1], shape)
    if names is not None and len(lines) > 1:
        units = [_unit_of(name) for name in names]
        over = _words(lines[-2][1], shape)
        if over is not None and _is_units(names, units):
            joined = [
                f"{name} [{unit}]" if unit and any_unit(unit) else name
                for name, unit in zip(over, units, strict=True)
            ]
            return _unique(joined), [f"{path.name}: row {lines[-1][0]} has the units"]
    if names is None:
        line, text = lines[-1]
        return numbers, [
            f"{path.name}: row {line}, above the rows ({_shown(text)}), does not have "
            f"{shape.width} names; the columns are named by their numbers"
        ]
    return _unique(names), []


def _words(text: str, shape: RowShape) -> list[str] | None:
    """Split the line into words, one per column; return None if their number differs."""
    stripped = text.lstrip("#%/ ")
    for words in ([name.strip() for name in shape.form.split(stripped)], stripped.split()):
        if len(words) == shape.width and any(words):
            return words
    return None


def _unit_of(word: str) -> str:
    return word.strip("[]() ")


def _is_units(words: Sequence[str], units: Sequence[str]) -> bool:
    """Tell whether the line is a row of units: at least half of the words, and at least one, are
    known units."""
    said = [unit for word, unit in zip(words, units, strict=True) if word not in ("", "-")]
    known = sum(any_unit(unit) for unit in said)
    return known > 0 and 2 * known >= len(said)


def _unique(names: Sequence[str]) -> list[str]:
    """Make the names unique: a repeated name gets its column's number appended, a missing name
    becomes the number."""
    found: list[str] = []
    for number, name in enumerate(names, start=1):
        own = name or str(number)
        found.append(own if own not in found else f"{own} ({number})")
    return found
