"""Finds and calls the readers of foreign files, which are plug-ins of the entry-point group
``arctrue.readers``.

Each reader is a module or object with ``recognises`` and ``read``. The readers of this package are
registered (in pyproject.toml) in the same way as readers of other packages.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from typing import Protocol

import numpy as np

from arctrue.importing.choices import Ambiguous, AmbiguousError, Choices, checked_period
from arctrue.importing.file_content import FileContent, Known
from arctrue.importing.gzip_file import is_gzip, unpacked
from arctrue.measurement import MeasurementError

GROUP = "arctrue.readers"
HEAD_BYTES = 65536


@dataclass(frozen=True)
class ReadSettings:
    """Statements of the user about the form of the files; "" or None means no statement.

    Parameters
    ----------
    delimiter : {"", "comma", "semicolon", "tab", "space"}, optional
        Separator of the columns of a text file.
    decimal : {"", "point", "comma"}, optional
        Decimal sign of the numbers of a text file.
    group : str, optional
        Place of the columns in a file with several tables.
    period_s : float, optional
        Time between two rows, seconds.
    """

    delimiter: str = ""
    decimal: str = ""
    group: str = ""
    period_s: float | None = None


class Reader(Protocol):
    """Defines the interface of a reader, which is the object of an entry point."""

    def recognises(self, path: Path, head: bytes) -> bool:
        """Tell whether a file has the format of this reader.

        Parameters
        ----------
        path : Path
            The file.
        head : bytes
            First bytes of the file.

        Returns
        -------
        bool
            True if :meth:`read` can read it.
        """
        ...

    def read(self, path: Path, settings: ReadSettings, choices: Choices) -> FileContent:
        """Read the columns of a file.

        Parameters
        ----------
        path : Path
            The file.
        settings : ReadSettings
            Statements of the user about the file.
        choices : Choices
            Asks the user for missing statements.

        Returns
        -------
        FileContent
            Columns of the file.

        Raises
        ------
        MeasurementError
            If the file is damaged; the error names row and column if they are known.
        AmbiguousError
            If a question is open.
        OSError
            If the file cannot be read.
        """
        ...


@cache
def readers() -> Mapping[str, Reader]:
    """Return all readers.

    Returns
    -------
    mapping of str to Reader
        Readers by name.

    Raises
    ------
    ValueError
        If a plug-in cannot be loaded or lacks a function, or if no reader is installed.
    """
    found: dict[str, Reader] = {}
    for point in sorted(entry_points(group=GROUP), key=lambda point: point.name):
        try:
            reader = point.load()
        except Exception as error:
            raise ValueError(f"the reader {point.name} ({point.value}): {error}") from error
        if not all(callable(getattr(reader, name, None)) for name in ("recognises", "read")):
            raise ValueError(
                f"the reader {point.name} ({point.value}): has no functions recognises and read"
            )
        found[point.name] = reader
    if not found:
        raise ValueError(
            "no reader is installed: the package's entry points are missing; install it again "
            "(make setup in a source tree)"
        )
    return found


FALLBACK = "text"
"""Name of the reader that accepts any text; it is tried last."""


def read_recording(path: Path, name: str, settings: ReadSettings, choices: Choices) -> FileContent:
    """Read a file; a gzip file is unpacked first.

    Parameters
    ----------
    path : Path
        The file.
    name : str
        Name of the reader; "" selects the reader that recognises the file (if several do, the user
        chooses one), or else the text reader.
    settings : ReadSettings
        Statements of the user about the file.
    choices : Choices
        Asks the user for missing statements.

    Returns
    -------
    FileContent
        Columns of the file.

    Raises
    ------
    MeasurementError
        If the file is damaged or empty, or is a folder.
    AmbiguousError
        If a question is open.
    ValueError
        If no reader has that name, a plug-in cannot be used, or the period is not above 0.
    """
    if settings.period_s is not None:
        checked_period(settings.period_s)
    recording = _unpacked_or_read(path, name, settings, choices)
    if settings.period_s is None or "time" in recording.known:
        return recording
    time_s = np.arange(recording.rows) * settings.period_s
    return replace(
        recording,
        columns={**recording.columns, "row_time_s": time_s},
        known={**recording.known, "time": Known("row_time_s", "s")},
        notes=(*recording.notes, f"{path.name}: time = row × {settings.period_s:g} s"),
    )


def _unpacked_or_read(
    path: Path, name: str, settings: ReadSettings, choices: Choices
) -> FileContent:
    """Read the file; a gzip file is first unpacked into a temporary folder."""
    if path.is_dir() or not is_gzip(path):
        return _read(path, name, settings, choices)
    with unpacked(path) as inside:
        try:
            recording = _read(inside, name, settings, choices)
        except MeasurementError as error:
            raise error.of_file(path) from error
        except AmbiguousError as error:
            asked = error.asked
            question = asked.question.replace(str(inside), str(path))
            raise AmbiguousError(replace(asked, question=question)) from error
    note = f"{path.name}: was unpacked; the file inside is called {inside.name} here"
    return replace(recording, path=path, notes=(note, *recording.notes))


def _read(path: Path, name: str, settings: ReadSettings, choices: Choices) -> FileContent:
    known = readers()
    if name:
        if name not in known:
            raise ValueError(f"no reader {name!r}; there are {', '.join(known)}")
        return known[name].read(path, settings, choices)
    if path.is_dir():
        raise MeasurementError("format", path, "is a folder, expected a file")
    with path.open("rb") as file:
        head = file.read(HEAD_BYTES)
    if not head.strip():
        raise MeasurementError("empty", path, "is empty")
    fits = [
        key for key, reader in known.items() if key != FALLBACK and reader.recognises(path, head)
    ]
    if len(fits) > 1:
        fits = [choices.ask(Ambiguous("--format", f"{path}: several formats fit.", fits))]
    return known[fits[0] if fits else FALLBACK].read(path, settings, choices)
