"""Reads the lines of a text file in the file's own encoding."""

from __future__ import annotations

import codecs
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from arctrue.measurement import MeasurementError

_BLOCK = 1 << 20
LONGEST_LINE = 1_000_000
"""Largest number of characters in a line; a longer line is not a row of a table."""
_MARKS = (  # UTF-32 comes before UTF-16, because its byte order mark begins with the mark of UTF-16
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_OTHER_FILES = {  # message for a file that begins with these bytes
    b"PK\x03\x04": "is an archive or a workbook: save the sheet of a workbook as CSV; unpack an "
    "archive first",
    b"\xd0\xcf\x11\xe0": "is a workbook of an old Excel version: save the sheet as CSV",
    b"BZh": "is packed by bzip2: unpack it first (bunzip2)",
    b"\xfd7zXZ": "is packed by xz: unpack it first (unxz)",
    b"\x28\xb5\x2f\xfd": "is packed by zstd: unpack it first (unzstd)",
    b"TDSm": "is a TDMS file of LabVIEW: export it as CSV",
}


@dataclass(frozen=True)
class Encoding:
    """Encoding of a file, and a note about it for the user ("" for UTF-8)."""

    name: str
    note: str


def encoding_of(path: Path) -> Encoding:
    """Find the encoding by the byte order mark; a file without a mark is UTF-8 if it is valid
    UTF-8, otherwise Windows-1252.

    UTF-16 without a mark is recognised by its zero bytes. Windows-1252 has all letters of Latin-1.
    Raises MeasurementError for a file that is not text.
    """
    with path.open("rb") as file:
        head = file.read(4096)
    for first, said in _OTHER_FILES.items():
        if head.startswith(first):
            raise MeasurementError("format", path, said)
    for mark, name in _MARKS:
        if head.startswith(mark):
            return Encoding(name, f"{path.name}: text in {name.upper()}")
    if b"\0" in head:
        for name, zeros in (("utf-16-le", head[1::2]), ("utf-16-be", head[::2])):
            # In UTF-16 every second byte of digits and Latin letters is zero.
            if zeros.count(0) > 0.7 * len(zeros):
                return Encoding(name, f"{path.name}: text in {name.upper()}, without its mark")
        raise MeasurementError(
            "format", path, "is neither text nor a format that a reader recognises"
        )
    for name in ("utf-8-sig", "cp1252"):
        if _decodes(path, name):
            usual = name == "utf-8-sig"
            note = f"{path.name}: is not UTF-8; read as Windows-1252, a superset of Latin-1"
            return Encoding(name, "" if usual else note)
    raise MeasurementError(
        "format", path, "is text neither in UTF-8 nor in Latin-1: save it as UTF-8"
    )


def _decodes(path: Path, name: str) -> bool:
    decoder = codecs.getincrementaldecoder(name)()
    try:
        with path.open("rb") as file:
            while block := file.read(_BLOCK):
                decoder.decode(block)
        decoder.decode(b"", final=True)
    except UnicodeDecodeError:
        return False
    return True


class TextLines:
    """The non-empty lines of a file with their numbers; ``ended`` tells whether the last line ends
    with a line feed."""

    def __init__(self, path: Path, encoding: Encoding) -> None:
        """Prepare to read from the first line."""
        self._path = path
        self._encoding = encoding.name
        self.ended = True

    def __iter__(self) -> Iterator[tuple[int, str]]:
        """Yield the number and the stripped text of each line that is not empty. Raises
        MeasurementError for a line that is too long."""
        try:
            with self._path.open(encoding=self._encoding) as file:
                number = 0
                while text := file.readline(LONGEST_LINE):
                    number += 1
                    self.ended = text.endswith("\n")
                    if not self.ended and len(text) == LONGEST_LINE:
                        raise MeasurementError(
                            "format",
                            self._path,
                            f"the line is longer than {LONGEST_LINE:,} characters: no table",
                            row=number,
                        )
                    stripped = text.strip("\r\n ")
                    if stripped.strip():
                        yield number, stripped
        except UnicodeDecodeError as error:
            raise MeasurementError(
                "format", self._path, f"is not text in {self._encoding.upper()} to its end"
            ) from error
