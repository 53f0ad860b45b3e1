"""Determines the form of a text table: separator, decimal sign, and which fields of a row are
numbers."""

from __future__ import annotations

import contextlib
import csv
import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from arctrue.importing.choices import Ambiguous, Choices
from arctrue.importing.reader import ReadSettings
from arctrue.importing.sexagesimal import is_sexagesimal
from arctrue.measurement import MeasurementError

DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "space": None}
COMMENT = ("#", "%", "//")
POINT = r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?"
COMMA = r"[+-]?(\d+,?\d*|,\d+)([eEdD][+-]?\d+)?"
THOUSANDS = r"[+-]?[1-9]\d{0,2}(,\d{3})+(\.\d*)?"
MISSING = ("", "nan", "na", "n/a", "null", "none", "--")
_POINT, _COMMA, _THOUSANDS = (re.compile(rf"{form}\Z") for form in (POINT, COMMA, THOUSANDS))


@dataclass(frozen=True)
class Form:
    """Separator of columns and decimal sign of a file."""

    delimiter: str
    decimal: str

    def split(self, line: str) -> list[str]:
        """Divide a line into its fields."""
        sign = DELIMITERS[self.delimiter]
        if sign is None:
            return line.split()
        if '"' in line:
            # A field above the limit of the csv module is not a number, with or without quotes.
            with contextlib.suppress(csv.Error):
                return [field.strip() for field in next(csv.reader([line], delimiter=sign))]
        return [field.strip() for field in line.split(sign)]

    def number_pattern(self) -> str:
        """Return the regular expression of a number with this decimal sign."""
        if self.decimal == "comma":
            return COMMA
        return POINT if self.delimiter == "comma" else f"({POINT}|{THOUSANDS})"

    def is_number(self, text: str) -> bool:
        """Tell whether the text is a number with this decimal sign."""
        if self.decimal == "comma":
            return bool(_COMMA.match(text))
        return bool(_POINT.match(text) or (self.delimiter != "comma" and _THOUSANDS.match(text)))

    def weight(self, text: str) -> int:
        """Count the numbers in a field; a sexagesimal angle or time counts as three."""
        if self.is_number(text):
            return 1
        return 3 if is_sexagesimal(text, spaces=self.delimiter != "space") else 0


@dataclass(frozen=True)
class RowShape:
    """The form of a row: the row has ``width`` fields, and the columns ``numeric`` hold numbers or
    missing values."""

    form: Form
    width: int
    numeric: frozenset[int]

    def is_words(self, fields: Sequence[str]) -> bool:
        """Tell whether the fields form a line of words, for example a heading, a remark, or
        statistics after the rows.

        A row whose first number is correct and that has a wrong field later is faulty; it is not a
        line of words.
        """
        if len(fields) != self.width:
            return any(field and not self.form.weight(field) for field in fields)
        wrong = {
            place
            for place in self.numeric
            if fields[place].lower() not in MISSING and not self.form.weight(fields[place])
        }
        right = any(self.form.weight(fields[place]) for place in self.numeric)
        return bool(wrong) and (not right or min(self.numeric) in wrong)


def form_of(path: Path, lines: Sequence[str], settings: ReadSettings, choices: Choices) -> Form:
    """Return the form that :func:`_score` rates highest; if several have this rating, the user
    chooses one.

    Raises MeasurementError if no form matches, AmbiguousError, ValueError for an unknown setting.
    """
    for value, known, option in (
        (settings.delimiter, [*DELIMITERS], "--delimiter"),
        (settings.decimal, ["point", "comma"], "--decimal"),
    ):
        if value and value not in known:
            raise ValueError(f"{option} {value}: expected one of {', '.join(known)}")
    delimiters = [settings.delimiter] if settings.delimiter else [*DELIMITERS]
    decimals = [settings.decimal] if settings.decimal else ["point", "comma"]
    data = [text for text in lines if not text.startswith(COMMENT)]
    forms: dict[Form, tuple[int, int]] = {}
    for delimiter, decimal in itertools.product(delimiters, decimals):
        if delimiter == "comma" and decimal == "comma":
            continue
        form = Form(delimiter, decimal)
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
    equal = all(best[0].split(text) == form.split(text) for form in best[1:] for text in data)
    if len(by_delimiter) > 1 and not equal:
        given = choices.ask(
            Ambiguous("--delimiter", f"{path}: several separators fit.", [*by_delimiter])
        )
        best = [form for form in best if form.delimiter == given]
    if len(best) > 1 and any(_has_comma(form, data) for form in best):
        given = choices.ask(
            Ambiguous(
                "--decimal",
                f"{path}: numbers have commas; what is the decimal sign?",
                ["point", "comma"],
            )
        )
        best = [form for form in best if form.decimal == given]
    return best[0]


def _has_comma(form: Form, data: Sequence[str]) -> bool:
    return form.delimiter != "comma" and any("," in text for text in data)


def _score(form: Form, data: Sequence[str]) -> tuple[int, int] | None:
    """Rate a form; return None if no line has a number in this form.

    Each group of lines with the same number of fields has a rating. The function returns the
    highest rating: the number of numbers minus the number of other fields, and the number of lines.
    """
    widths: dict[int, int] = {}
    numbers: dict[int, int] = {}
    for text in data:
        fields = form.split(text)
        weights = [form.weight(field) for field in fields]
        if any(weights):
            widths[len(fields)] = widths.get(len(fields), 0) + 1
            # In "1,5;2,5" a comma as delimiter gives the field "5;2", which is not a number and
            # lowers the rating of the comma.
            others = sum(not weight for weight in weights)
            numbers[len(fields)] = numbers.get(len(fields), 0) + sum(weights) - others
    if not widths:
        return None
    width = max(widths, key=lambda key: (numbers[key], key))
    return numbers[width], widths[width]


def row_shape(lines: Sequence[str], form: Form) -> RowShape | None:
    """Return the most frequent form of the lines with numbers; None if no line has a number."""
    shapes: dict[tuple[int, tuple[int, ...]], int] = {}
    for text in lines:
        if text.startswith(COMMENT):
            continue
        fields = form.split(text)
        places = tuple(place for place, field in enumerate(fields) if form.weight(field))
        if places:
            shapes[len(fields), places] = shapes.get((len(fields), places), 0) + 1
    if not shapes:
        return None
    width, places = max(shapes, key=lambda shape: shapes[shape])
    return RowShape(form, width, frozenset(places))
