"""Receives files that a user drops into the page: a measurement set, or recordings of other
programs.

ArcTrue's readers read the files from a separate folder and execute no code from them.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Protocol

from arctrue.base.printable import one_line
from arctrue.importing import (
    Ambiguous,
    AmbiguousError,
    Choices,
    ReadSettings,
    Settings,
)
from arctrue.importing.preview import Preview
from arctrue.importing.questions import Import
from arctrue.measurement import Origin, Table, read_measurement_set, write_measurement_set
from arctrue.measurement.description import FILE_NAME

MOST_FILES = 16
_LONGEST = 80
_SAFE = re.compile(r"[^\w.\- ]+")


class Sent(Protocol):
    """The methods of an uploaded file (of an HTML form) that this module uses."""

    filename: str | None

    def save(self, dst: str) -> None:
        """Write the file to ``dst``."""
        ...


@dataclass(frozen=True)
class Received:
    """A set that was made from uploaded files, and the options of ``arctrue import`` that make the
    set again."""

    title: str
    files: list[str]
    answers: list[tuple[str, str]]
    imported: bool


class OpenQuestionsError(ValueError):
    """Is raised if the files leave the questions ``asked`` open; it contains the ``answers`` so far
    and the previews."""

    def __init__(
        self, asked: Sequence[Ambiguous], answers: Mapping[str, str], previews: Sequence[Preview]
    ) -> None:
        """Store the values that the form of questions shows."""
        super().__init__(", ".join(item.name for item in asked))
        self.asked, self.answers, self.previews = asked, answers, previews


def keep(sent: Sequence[Sent], folder: Path) -> list[Path]:
    """Write the files into ``folder`` under safe names. Raises ValueError."""
    there = [file for file in sent if file.filename]
    if not there:
        raise ValueError("no file was chosen: choose or drop at least one")
    if len(there) > MOST_FILES:
        raise ValueError(f"{len(there)} files at once; expected at most {MOST_FILES}")
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for file in there:
        path = folder / safe_name(file.filename or "")
        if path in paths:
            raise ValueError(f"{path.name}: two files of this name were sent")
        file.save(str(path))
        paths.append(path)
    return paths


def safe_name(name: str) -> str:
    """Return the last part of a path without characters that have a meaning to operating
    systems."""
    last = re.split(r"[/\\]", name)[-1]
    safe = _SAFE.sub("_", one_line(last)).lstrip(".").strip()[-_LONGEST:]
    return safe or "file"


def receive(paths: Sequence[Path], out: Path, answers: Mapping[str, str]) -> Received:
    """Make the set ``out`` from stored files.

    If a measurement.toml is among the files, they are copied as a set; otherwise they are imported
    as by ``arctrue import``. ``answers`` contains the answers by the names of the questions
    (``--unit head1``). Raises OpenQuestionsError with all questions that are open,
    MeasurementError, ValueError.
    """
    if any(path.name == FILE_NAME for path in paths):
        out.mkdir(parents=True, exist_ok=True)
        for path in paths:
            shutil.copyfile(path, out / path.name)
        title = read_measurement_set(out).title or "dropped in"
        return Received(title, [path.name for path in paths], [], imported=False)
    import_ = Import(paths, "", ReadSettings(), Settings(table=Table()))
    choices = Choices(lambda asked: _answer(asked, answers))
    try:
        imported = import_.run(choices)
    except AmbiguousError as error:
        given = {name: text for name, text in answers.items() if name != error.asked.name}
        asked = import_.questions(error.asked, given)
        raise OpenQuestionsError(asked, given, import_.previews()) from error
    names = [path.name for path in paths]
    title = imported.measurement.title or ", ".join(names)
    decided = tuple(one_line(text) for text in imported.notes)
    origin = Origin(None, f"arctrue {version('arctrue')}", decided)
    write_measurement_set(out, replace(imported.measurement, origin=origin, title=title))
    return Received(title, names, choices.answers, imported=True)


def _answer(asked: Ambiguous, answers: Mapping[str, str]) -> str:
    given = answers.get(asked.name, "").strip()
    if not given or (not asked.free_text and given not in asked.answers):
        raise AmbiguousError(asked)
    return given
