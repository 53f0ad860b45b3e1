"""Reads a CSV file of any length in blocks of typed columns.

pyarrow reads the file. If pyarrow fails, the module reads the file once more, line by line, to name
the row and column of the fault. Without pyarrow the lines are read one by one.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from arctrue.base.extras import LazyModule, installed
from arctrue.base.progress import ReportBytes
from arctrue.base.read_errors import unreadable
from arctrue.base.similar import similar
from arctrue.measurement.errors import MeasurementError
from arctrue.measurement.measurement_set import WHOLE_COLUMNS

if TYPE_CHECKING:
    import pyarrow as pa  # type: ignore[import-untyped]
    import pyarrow.compute as pc  # type: ignore[import-untyped]
    import pyarrow.csv as pa_csv  # type: ignore[import-untyped]
else:
    pa, pc, pa_csv = map(LazyModule, ("pyarrow", "pyarrow.compute", "pyarrow.csv"))

Columns = dict[str, NDArray[np.int64] | NDArray[np.float64]]

BLOCK_BYTES = 8 << 20
LINES_TOGETHER = 1 << 16
"""Number of rows in a block if pyarrow is missing and the lines are read one by one."""
_NOT_A_NUMBER = ("", "nan", "NaN", "NAN", "-nan", "-NaN", "null", "NULL", "NA", "N/A", "n/a")
_WHOLE = re.compile(r"-?[0-9]+\Z")
_FLOAT = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?\Z")
_INT64 = range(-(2**63), 2**63)
MISSPELT_RATIO = 0.75
"""Smallest similarity (difflib) to the name of a known column at which a name counts as misspelt. A
condition may have any name, so the limit is stricter than for a key: temprature_c (0.96) and time
(0.8) count as misspelt; duration_s (0.63) is a condition."""
LARGEST_NUMBER = 1e12
"""Largest accepted absolute value, in seconds, degrees, arcseconds or °C; a larger value means a
damaged field."""


@dataclass
class CsvFile:
    """One CSV file: the columns to read, the columns that it has, and warnings.

    With ``with_conditions`` every further column of numbers is read as a condition; a further
    column with any other content is left out with a warning.
    """

    path: Path
    required: Sequence[str]
    optional: Sequence[str]
    columns: list[str] = field(default_factory=list)
    header: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)
    report_bytes: ReportBytes | None = None
    """Function that is called for every block that pyarrow reads."""
    with_conditions: bool = False
    conditions: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Read the header and check its columns."""
        try:
            # The text layer decodes more than the header; only faults in the header are raised.
            with self.path.open(encoding="utf-8-sig", errors="surrogateescape", newline="") as file:
                first = file.readline()
            first.encode()
        except UnicodeEncodeError as error:
            raise MeasurementError("format", self.path, "is not text in UTF-8", row=1) from error
        except OSError as error:
            raise MeasurementError("missing", self.path, unreadable(error)) from error
        if not first.strip():
            raise MeasurementError(
                "empty",
                self.path,
                "is empty" if not first else "has no header; expected " + ",".join(self.required),
                row=None if not first else 1,
            )
        try:
            self.header = [name.strip() for name in next(csv.reader([first]))]
        except csv.Error as error:
            raise MeasurementError("format", self.path, str(error), row=1) from error
        for name in self.required:
            if name not in self.header:
                raise MeasurementError(
                    "missing",
                    self.path,
                    f"is missing; the header has {','.join(self.header)}",
                    row=1,
                    column=name,
                )
        for name in (*self.required, *self.optional):
            if self.header.count(name) > 1:
                raise MeasurementError("format", self.path, "occurs twice", row=1, column=name)
        self.columns = [n for n in (*self.required, *self.optional) if n in self.header]
        if self.with_conditions:
            self.conditions = [
                name
                for name in self.header
                if name and name not in self.columns and self.header.count(name) == 1
            ]
        many = {name: self.header.count(name) for name in self.header if name}
        self.warnings = [
            f"{self.path}, row 1, column {name}: occurs {count} times and is not used; "
            "rename the columns"
            for name, count in many.items()
            if count > 1
        ]
        self.warnings += [
            f"{self.path}: column {name or '(without a name)'} is not known and is not used"
            for name in dict.fromkeys(self.header)
            if name not in self.columns and name not in self.conditions and many.get(name, 1) == 1
        ]
        absent = [name for name in self.optional if name not in self.columns]
        self.warnings += [
            f"{self.path}: column {name} is taken as a condition of that name; is {near[0]} meant?"
            for name in self.conditions
            if (near := similar(name, absent, MISSPELT_RATIO))
        ]

    def blocks(self) -> Iterator[Columns]:
        """Yield blocks of rows: columns of whole numbers as int64, all other columns as float64.

        Raises MeasurementError with the row and column of the first field that is missing, not a
        number, not finite, or larger than LARGEST_NUMBER. A last line with too few fields and no
        line end is left out, with a warning.
        """
        cut = self._cut_last_line()
        if not installed("pyarrow"):
            yield from self._blocks_of_lines()
            return
        if self._may_hold_hexadecimal():
            self._check_lines()
        rows = 0
        size = self.path.stat().st_size
        try:
            for number, batch in enumerate(self._batches(cut), start=1):
                if self.report_bytes is not None:
                    self.report_bytes(self.path, min(number * BLOCK_BYTES, size), size)
                block = {}
                for name in self.columns:
                    column = batch.column(name)
                    if column.null_count:
                        self._explain()
                    values = _numbers(column)
                    if name not in WHOLE_COLUMNS and not (np.abs(values) <= LARGEST_NUMBER).all():
                        self._explain()
                    block[name] = values
                for name in list(self.conditions):
                    numbers = self._condition(name, batch.column(name), rows)
                    if numbers is not None:
                        block[name] = numbers
                rows += batch.num_rows
                if batch.num_rows:
                    yield block
        except pa.ArrowInvalid as error:
            if not rows and next(self._lines(), None) is None:
                raise self._no_rows() from error
            self._explain(error)
        if not rows:
            raise self._no_rows()

    def _blocks_of_lines(self) -> Iterator[Columns]:
        """Yield the same rows as :meth:`blocks` without pyarrow, about ten times more slowly."""
        rows = 0
        waiting: list[list[str]] = []
        try:
            for row, fields in self._lines():
                if self._cut_text and ",".join(fields) == self._cut_text:
                    continue
                self._check_line(row, fields)
                waiting.append(fields)
                if len(waiting) == LINES_TOGETHER:
                    yield self._block(waiting, rows)
                    rows, waiting = rows + len(waiting), []
        except csv.Error as error:
            raise MeasurementError("format", self.path, str(error)) from error
        if waiting:
            yield self._block(waiting, rows)
        elif not rows:
            raise self._no_rows()

    def _block(self, lines: list[list[str]], first: int) -> Columns:
        """Return checked lines as columns; stop reading a condition at its first field that is
        not a number."""
        columns = dict(zip(self.header, zip(*lines, strict=True), strict=False))
        block: Columns = {}
        for name in self.columns:
            texts = [text.strip() for text in columns[name]]
            if name in WHOLE_COLUMNS:
                block[name] = np.array([int(text) for text in texts], dtype=np.int64)
            else:
                block[name] = np.array([float(text) for text in texts])
        for name in list(self.conditions):
            texts = [text.strip() for text in columns[name]]
            wrong = [
                place
                for place, text in enumerate(texts)
                if not (_FLOAT.match(text) and abs(float(text)) <= LARGEST_NUMBER)
            ]
            if wrong:
                self._leave_out(name, first + wrong[0], columns[name][wrong[0]])
            else:
                block[name] = np.array([float(text) for text in texts])
        return block

    def _condition(self, name: str, texts: pa.Array, first: int) -> NDArray[np.float64] | None:
        """Return the numbers of a condition; None, with a warning, if one of its fields is
        not a number."""
        try:
            numbers = _numbers(pc.cast(pc.utf8_trim_whitespace(texts), pa.float64()))
            wrong = np.flatnonzero(~(np.abs(numbers) <= LARGEST_NUMBER))
        except pa.ArrowInvalid:
            fields = self._texts(texts)
            wrong = np.array([i for i, text in enumerate(fields) if not _FLOAT.match(text.strip())])
        if wrong.size == 0:
            return numbers
        place = int(wrong[0])
        self._leave_out(name, first + place, self._texts(texts[place : place + 1])[0])
        return None

    @staticmethod
    def _texts(column: pa.Array) -> list[str]:
        """Return the texts of a column, with � for bytes that are not UTF-8."""
        return [text.decode("utf-8", "replace") for text in column.cast(pa.binary()).to_pylist()]

    def _leave_out(self, name: str, index: int, text: str) -> None:
        """Stop reading a condition, with a warning, because one of its fields is not a number."""
        self.conditions.remove(name)
        self.warnings.append(
            f"{self.path}, row {self.row_of(index)}, column {name}: expected a number, "
            f"found {text!r}; the column is not used"
        )

    def row_of(self, index: int) -> int:
        """Return the line number of the data row ``index``, which counts from 0; blank lines and
        the header count as lines."""
        for number, (row, _) in enumerate(self._lines()):
            if number == index:
                return row
        return index + 2

    def _no_rows(self) -> MeasurementError:
        return MeasurementError("empty", self.path, "has a header and no rows", row=1)

    def _batches(self, cut: int | None) -> Iterator[pa.RecordBatch]:
        wanted = [*self.columns, *self.conditions]
        names = [name if name in wanted else f"unused {i}" for i, name in enumerate(self.header)]
        types = {
            name: pa.int64() if name in WHOLE_COLUMNS else pa.float64() for name in self.columns
        } | dict.fromkeys(self.conditions, pa.string())
        # Only an incomplete last line is skipped; any other line with too few or too many fields is
        # an error.
        handler = (lambda row: "skip" if row.text == self._cut_text else "error") if cut else None
        reader = pa_csv.open_csv(
            self.path,
            read_options=pa_csv.ReadOptions(
                block_size=BLOCK_BYTES, skip_rows=1, column_names=names, use_threads=False
            ),
            parse_options=pa_csv.ParseOptions(invalid_row_handler=handler),
            convert_options=pa_csv.ConvertOptions(
                column_types=types,
                include_columns=wanted,
                null_values=list(_NOT_A_NUMBER),
                check_utf8=False,
            ),
        )
        with reader:
            yield from reader

    _cut_text: str = ""

    def _cut_last_line(self) -> int | None:
        """Return the length of the last line if it has too few fields and no line end; otherwise
        None."""
        with self.path.open("rb") as file:
            size = file.seek(0, 2)
            file.seek(max(size - 65536, 0))
            tail = file.read()
        if not tail or tail.endswith((b"\n", b"\r")):
            return None
        last = tail.splitlines()[-1].decode("utf-8", "replace")
        fields = last.count(",") + 1
        if len(tail.splitlines()) == 1 and size == len(tail):
            return None  # the file contains only the header
        if fields >= len(self.header):
            self.warnings.append(f"{self.path}: the last line has no end; it may be cut off")
            return None
        self.warnings.append(
            f"{self.path}: the last line is cut off after {fields} of {len(self.header)} fields "
            f"({last!r}) and is left out"
        )
        self._cut_text = last
        return len(last)

    def _lines(self) -> Iterator[tuple[int, list[str]]]:
        with self.path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
            reader = csv.reader(file)
            for _ in reader:
                break
            for fields in reader:
                if fields:
                    yield reader.line_num, fields

    def _may_hold_hexadecimal(self) -> bool:
        """Tell whether the file may contain a text such as 0x10, which pyarrow would read as 16,
        although it is not a valid number here."""
        last = b""
        with self.path.open("rb") as file:
            while piece := file.read(BLOCK_BYTES):
                if b"0x" in (joined := last + piece) or b"0X" in joined:
                    return True
                last = piece[-1:]
        return False

    def _explain(self, cause: Exception | None = None) -> NoReturn:
        """Raise the error that names the first bad row and column."""
        self._check_lines()
        raise MeasurementError("format", self.path, f"cannot be read: {cause}") from cause

    def _check_lines(self) -> None:
        """Raise the error of the first faulty line; return if no line is faulty."""
        try:
            for row, fields in self._lines():
                if not (self._cut_text and ",".join(fields) == self._cut_text):
                    self._check_line(row, fields)
        except csv.Error as error:
            raise MeasurementError("format", self.path, str(error)) from error

    def _check_line(self, row: int, fields: Sequence[str]) -> None:
        """Raise an error if a line has a wrong number of fields or contains an invalid field."""
        if len(fields) != len(self.header):
            raise MeasurementError(
                "format",
                self.path,
                f"expected {len(self.header)} fields, found {len(fields)}",
                row=row,
                column=self.header[min(len(fields), len(self.header) - 1)],
            )
        for name in self.columns:
            self._check(fields[self.header.index(name)].strip(), row, name)

    def _check(self, text: str, row: int, name: str) -> None:
        kind = "a whole number" if name in WHOLE_COLUMNS else "a number"
        if text in _NOT_A_NUMBER:
            found = f"found {text!r}" if text else "the field is empty"
            raise MeasurementError(
                "not_a_number", self.path, f"expected {kind}, {found}", row=row, column=name
            )
        if name in WHOLE_COLUMNS:
            right = bool(_WHOLE.match(text))
            if right and int(text) not in _INT64:
                raise MeasurementError(
                    "value", self.path, f"{text} does not fit into 64 bits", row=row, column=name
                )
        else:
            right = bool(_FLOAT.match(text)) and math.isfinite(float(text))
            if re.fullmatch(r"[+-]?inf(inity)?", text, re.IGNORECASE):
                raise MeasurementError(
                    "not_a_number",
                    self.path,
                    f"expected {kind}, found {text!r}",
                    row=row,
                    column=name,
                )
        if not right:
            raise MeasurementError(
                "value", self.path, f"expected {kind}, found {text!r}", row=row, column=name
            )
        if name not in WHOLE_COLUMNS and abs(float(text)) > LARGEST_NUMBER:
            raise MeasurementError(
                "value",
                self.path,
                f"{text} is too large; expected a number within ±{LARGEST_NUMBER:g}",
                row=row,
                column=name,
            )


def _numbers(column: pa.Array) -> NDArray[Any]:
    """Return the numbers of a column; a missing number is nan.

    ``to_numpy`` would import pandas if it is installed, which takes longer than a short file.
    """
    if column.null_count:
        column = pc.fill_null(column, np.nan)
    return np.asarray(np.from_dlpack(column))
