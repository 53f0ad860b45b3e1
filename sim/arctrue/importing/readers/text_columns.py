"""Converts lines to columns of numbers or text, block by block; the lines are not kept."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arctrue.base.extras import LazyModule
from arctrue.importing.readers.text_form import DELIMITERS, MISSING, Form
from arctrue.importing.readers.unpacked_size import refuse_above_limit

if TYPE_CHECKING:
    import pyarrow as pa  # type: ignore[import-untyped]
    import pyarrow.compute as pc  # type: ignore[import-untyped]
else:
    pa, pc = LazyModule("pyarrow"), LazyModule("pyarrow.compute")

_WHOLE = r"\A[+-]?[0-9]+\z"
_BYTES_A_LETTER = 4


class TextColumns:
    """Columns of rows with ``width`` fields; the reader adds the rows block by block."""

    def __init__(self, path: Path, form: Form, width: int) -> None:
        """Create empty columns."""
        self._path, self._form = path, form
        self._parts: list[list[NDArray[Any] | pa.Array]] = [[] for _ in range(width)]
        self.rows = 0

    def fields(self, texts: Sequence[str]) -> list[pa.Array] | None:
        """Divide lines into columns of text; return None if a line has another number of fields."""
        if any('"' in text for text in texts):
            return self._of_lists([self._form.split(text) for text in texts])
        lines = pa.array(texts, pa.large_string())
        sign = DELIMITERS[self._form.delimiter]
        divided = (
            pc.utf8_split_whitespace(pc.utf8_trim_whitespace(lines))
            if sign is None
            else pc.split_pattern(lines, sign)
        )
        width = len(self._parts)
        if not (pc.list_value_length(divided).to_numpy() == width).all():
            return None
        flat = pc.list_flatten(divided)
        every = np.arange(0, len(flat), width)
        return [pc.utf8_trim_whitespace(flat.take(every + place)) for place in range(width)]

    def _of_lists(self, rows: Sequence[Sequence[str]]) -> list[pa.Array] | None:
        if any(len(row) != len(self._parts) for row in rows):
            return None
        return [pa.array(column, pa.large_string()) for column in zip(*rows, strict=True)]

    def add(self, columns: Sequence[pa.Array]) -> None:
        """Add a block's fields to the columns. Raises MeasurementError if the columns exceed the
        memory limit."""
        self.rows += len(columns[0])
        refuse_above_limit(self._path, self.rows * len(columns) * 8)
        for parts, texts in zip(self._parts, columns, strict=True):
            parts.append(self._converted(texts))

    def _converted(self, texts: pa.Array) -> NDArray[Any] | pa.Array:
        """Return the texts as whole numbers, or as numbers with NaN for missing fields; if a text
        is not a number, return the texts."""
        if pc.all(pc.match_substring_regex(texts, _WHOLE)).as_py():
            try:
                return pc.cast(_without_plus(texts), pa.int64()).to_numpy()
            except pa.ArrowInvalid:  # does not fit into 64 bits
                return texts
        number = pc.match_substring_regex(texts, rf"\A{self._form.number_pattern()}\z")
        missing = pc.is_in(pc.utf8_lower(texts), value_set=pa.array(MISSING, pa.large_string()))
        if not pc.all(pc.or_(number, missing)).as_py():
            return texts
        decimal = "." if self._form.decimal == "comma" else ""
        plain = pc.replace_substring(_without_plus(texts), ",", decimal)
        plain = pc.replace_substring_regex(plain, "[dD]", "e")
        plain = pc.if_else(missing, pa.scalar(None, pa.large_string()), plain)
        return pc.cast(plain, pa.float64()).to_numpy(zero_copy_only=False)

    def finished(self) -> list[NDArray[Any]]:
        """Return the columns (int64, float64 or text), and free the memory of the blocks."""
        found = []
        while self._parts:
            found.append(self._joined(self._parts.pop(0)))
        return found

    def _joined(self, parts: list[NDArray[Any] | pa.Array]) -> NDArray[Any]:
        if all(isinstance(part, np.ndarray) for part in parts):
            joined = np.concatenate(parts)
            parts.clear()
            return joined
        longest = max(
            32 if isinstance(part, np.ndarray) else pc.max(pc.utf8_length(part)).as_py() or 0
            for part in parts
        )
        refuse_above_limit(self._path, sum(map(len, parts)) * longest * _BYTES_A_LETTER)
        return np.concatenate([_as_text(part) for part in parts])


def _without_plus(texts: pa.Array) -> pa.Array:
    return pc.replace_substring_regex(texts, r"\A\+", "")


def _as_text(part: NDArray[Any] | pa.Array) -> NDArray[np.str_]:
    if isinstance(part, np.ndarray):
        # This block contains numbers, but another block of the same column contains text.
        return np.array(["" if value != value else repr(value) for value in part.tolist()])
    return np.array(part.to_pylist(), dtype=np.str_)
