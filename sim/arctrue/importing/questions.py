"""Runs an import and collects all of its open questions at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from arctrue.importing.assemble import Imported, import_recordings
from arctrue.importing.choices import Ambiguous, Choices, open_questions
from arctrue.importing.columns import NONE
from arctrue.importing.file_content import FileContent
from arctrue.importing.preview import Preview, preview_of, preview_of_file
from arctrue.importing.reader import ReadSettings, read_recording
from arctrue.importing.settings import Settings

TRIED_ROWS = 2000
"""Number of rows at the start of each file that a trial import reads to find the open
questions."""


@dataclass
class Import:
    """One import: its files, the user's statements and, until they are imported, the contents of
    the files."""

    files: Sequence[Path]
    reader: str
    reading: ReadSettings
    settings: Settings
    recordings: list[FileContent] | None = field(default=None)

    def run(self, choices: Choices) -> Imported:
        """Make the measurement set. Raises MeasurementError, AmbiguousError, ValueError,
        OSError."""
        self.recordings = self._read(choices)
        imported = import_recordings(self.recordings, self.settings, choices)
        # The contents are deleted here, because they may fill most of the memory.
        self.recordings = None
        return imported

    def _read(self, choices: Choices) -> list[FileContent]:
        return [read_recording(path, self.reader, self.reading, choices) for path in self.files]

    def _try(self, choices: Choices) -> Imported:
        held = self._read(choices) if self.recordings is None else self.recordings
        return import_recordings(
            [recording.first(TRIED_ROWS) for recording in held], self.settings, choices
        )

    def questions(
        self, first: Ambiguous, given: Mapping[str, str] | None = None
    ) -> list[Ambiguous]:
        """Return the open question ``first`` and all others that are already known to be open.

        ``given``: answers to earlier questions, by :attr:`Ambiguous.name`.
        """
        others = open_questions(self._try, NONE, given or {})
        return [first, *(asked for asked in others if asked.name != first.name)]

    def previews(self) -> list[Preview]:
        """Return the preview of each file: its first rows, or its first lines if no reader could
        read it yet."""
        if self.recordings is None:
            found = [preview_of_file(path) for path in self.files]
            return [preview for preview in found if preview is not None]
        return [preview_of(recording) for recording in self.recordings]
