"""The open questions of an import on one screen, with the first rows of the files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from arctrue.cli._terminal import note
from arctrue.importing import (
    Ambiguous,
    Choices,
    FileContent,
    Imported,
    ReadSettings,
    Settings,
    import_recordings,
    read_recording,
)
from arctrue.importing.choices import open_questions
from arctrue.importing.columns import NONE

TRIED_ROWS = 2000
"""Rows that show which questions follow from the first."""
SHOWN_ROWS, SHOWN_COLUMNS, SHOWN_LETTERS = 4, 12, 20


@dataclass
class Import:
    """Files and what was said of them; ``recordings``: what was read, while it is needed."""

    files: Sequence[Path]
    reader: str
    reading: ReadSettings
    settings: Settings
    recordings: list[FileContent] | None = field(default=None)

    def run(self, choices: Choices) -> Imported:
        """The set. Raises MeasurementError, AmbiguousError, ValueError, OSError."""
        self.recordings = self._read(choices)
        imported = import_recordings(self.recordings, self.settings, choices)
        # It is not needed any more, and may be most of the memory.
        self.recordings = None
        return imported

    def _read(self, choices: Choices) -> list[FileContent]:
        return [read_recording(path, self.reader, self.reading, choices) for path in self.files]

    def _try(self, choices: Choices) -> Imported:
        held = self._read(choices) if self.recordings is None else self.recordings
        return import_recordings(
            [recording.first(TRIED_ROWS) for recording in held], self.settings, choices
        )

    def questions(self, first: Ambiguous) -> list[Ambiguous]:
        """``first``, which is open, and those that are open as well as far as can be known."""
        others = open_questions(self._try, NONE)
        return [first, *(asked for asked in others if asked.name != first.name)]

    def all_open(self, first: Ambiguous) -> str:
        """What a script is told: every question, what to type, and the first rows."""
        asked = self.questions(first)
        if len(asked) == 1:
            return "\n".join([asked[0].in_words(), *self.preview()])
        return "\n".join(
            [
                f"{len(asked)} questions are open, and the answers may lead to others:",
                *(f"{number}. {item.in_words()}" for number, item in enumerate(asked, start=1)),
                *self.preview(),
            ]
        )

    def preview(self) -> list[str]:
        """The first rows of each file; its first lines where it could not be read yet."""
        if self.recordings is None:
            return [line for path in self.files for line in _first_lines(path)]
        return [line for recording in self.recordings for line in _first_rows(recording)]


@dataclass
class Asker:
    """Asks at the terminal; before the first question all of them are shown."""

    import_: Import
    ask: Callable[[Ambiguous], str]
    _shown: bool = False

    def __call__(self, asked: Ambiguous) -> str:
        """The answer."""
        if not self._shown:
            self._shown = True
            for line in self.import_.preview():
                note(line)
            open_ = self.import_.questions(asked)
            note(f"open: {', '.join(item.name for item in open_)}")
        return self.ask(asked)


def _first_rows(recording: FileContent) -> list[str]:
    names = list(recording.columns)[:SHOWN_COLUMNS]
    cells = [[f"{number} {name}" for number, name in enumerate(names, start=1)]]
    for row in range(min(SHOWN_ROWS, recording.rows)):
        cells.append([_cell(recording.columns[name][row]) for name in names])
    cells = [[cell[:SHOWN_LETTERS] for cell in row] for row in cells]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    more = len(recording.columns) - len(names)
    beyond = f", the first {len(names)} of {len(names) + more} columns" if more else ""
    return [
        f"first rows of {recording.path.name}{beyond}:",
        *(
            "  " + "  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True))
            for row in cells
        ),
    ]


def _cell(value: object) -> str:
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def _first_lines(path: Path) -> list[str]:
    try:
        with path.open("rb") as file:
            head = file.read(4096)
    except OSError:
        return []
    if b"\0" in head or head.startswith(b"\x1f\x8b"):
        return []
    lines = head.decode("utf-8", "replace").splitlines()[:SHOWN_ROWS]
    return [f"first lines of {path.name}:", *(f"  {line[:120]}" for line in lines)]
