"""Turns recordings of other programs into a measurement set.

A reader (``readers``, found by the entry points ``arctrue.readers``) reads a file into a
:class:`FileContent`; ``columns`` assigns the file's columns to quantities and units; ``motion``
finds where the angle wraps at a full turn, and divides the rows into runs and cycles over the
stations; ``clocks`` aligns the clocks of two logs; ``assemble`` makes the set. If a file does not
state something, such as a unit, the import asks the user through ``choices``. The import reports
every decision.
"""

from arctrue.importing.assemble import Imported, import_recordings
from arctrue.importing.choices import Ambiguous, AmbiguousError, Choices
from arctrue.importing.file_content import FileContent
from arctrue.importing.reader import Reader, ReadSettings, read_recording, readers
from arctrue.importing.settings import Settings

Recording = FileContent
"""``Recording`` is the former name of FileContent; it is kept for one release, because readers of
other packages may use it."""

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
