"""Makes a preview of a file's first rows; a question about the columns shows it to the user."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from arctrue.importing.file_content import FileContent

SHOWN_ROWS, SHOWN_COLUMNS, SHOWN_LETTERS = 4, 12, 20
_LINE_LETTERS = 120
_HEAD_BYTES = 4096


@dataclass(frozen=True)
class Preview:
    """Preview of a file: its first rows as texts."""

    title: str
    header: tuple[str, ...]
    """Number and name of each shown column; empty if the file was not divided into columns."""
    rows: tuple[tuple[str, ...], ...]
    """Texts of each row, one per shown column; without columns one text, the beginning of the
    line."""

    def lines(self) -> list[str]:
        """Return the preview as text for a terminal: the title, and the rows in aligned columns."""
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
    """Return the preview of a file that a reader has read."""
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
    """Return the preview of a text file that no reader could read yet; None for a file that is
    not text or cannot be opened."""
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
