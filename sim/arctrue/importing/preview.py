"""The first rows of a file as text; a question about the columns shows them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from arctrue.importing.file_content import FileContent

SHOWN_ROWS, SHOWN_COLUMNS, SHOWN_LETTERS = 4, 12, 20
_LINE_LETTERS = 120
_HEAD_BYTES = 4096


@dataclass(frozen=True)
class Preview:
    """The beginning of a file."""

    title: str
    header: tuple[str, ...]
    """Number and name of each column; empty if the file could not be divided into columns."""
    rows: tuple[tuple[str, ...], ...]
    """One text per column; the whole line if there are no columns."""

    def lines(self) -> list[str]:
        """Format the preview for a terminal: the title, and the rows in aligned columns."""
        cells = [self.header, *self.rows] if self.header else list(self.rows)
        widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
        if not self.header:
            return [f"{self.title}:", *(f"  {line}" for (line,) in cells)]
        return [
            f"{self.title}:",
            *(
                "  " + "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True))
                for row in cells
            ),
        ]


def preview_of(recording: FileContent) -> Preview:
    """Give the first rows of a file that was read."""
    names = list(recording.columns)[:SHOWN_COLUMNS]
    more = len(recording.columns) - len(names)
    beyond = f", the first {len(names)} of {len(names) + more} columns" if more else ""
    rows = [
        tuple(_cell(recording.columns[name][row]) for name in names)
        for row in range(min(SHOWN_ROWS, recording.rows))
    ]
    header = tuple(f"{number} {name}"[:SHOWN_LETTERS] for number, name in enumerate(names, start=1))
    return Preview(f"first rows of {recording.path.name}{beyond}", header, tuple(rows))


def preview_of_file(path: Path) -> Preview | None:
    """Give the first lines of a text file that could not be read yet; None for files that are no
    text."""
    try:
        with path.open("rb") as file:
            head = file.read(_HEAD_BYTES)
    except OSError:
        return None
    if b"\0" in head or head.startswith(b"\x1f\x8b"):
        return None
    lines = head.decode("utf-8", "replace").splitlines()[:SHOWN_ROWS]
    rows = tuple((line[:_LINE_LETTERS],) for line in lines)
    return Preview(f"first lines of {path.name}", (), rows)


def _cell(value: object) -> str:
    return (f"{value:.10g}" if isinstance(value, float) else str(value))[:SHOWN_LETTERS]
