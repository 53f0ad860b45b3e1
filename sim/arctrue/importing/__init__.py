"""Turns recordings of other programs into a measurement set.

A reader (``readers``, found by the entry points ``arctrue.readers``) makes a
:class:`FileContent` of a file; ``columns`` says what its columns are and in which unit; ``motion``
finds wraps, runs and cycles; ``clocks`` brings two logs to one clock; ``assemble`` makes the set.
Whatever the file does not settle is asked through ``choices``, and every decision is told.
"""

from arctrue.importing.assemble import Imported, Settings, import_recordings
from arctrue.importing.choices import Ambiguous, AmbiguousError, Choices
from arctrue.importing.file_content import FileContent
from arctrue.importing.reader import Reader, ReadSettings, read_recording, readers

Recording = FileContent
"""The former name, for readers of other packages; kept for one release."""

__all__ = [
    "Ambiguous",
    "AmbiguousError",
    "Choices",
    "FileContent",
    "Imported",
    "ReadSettings",
    "Reader",
    "Recording",
    "Settings",
    "import_recordings",
    "read_recording",
    "readers",
]
