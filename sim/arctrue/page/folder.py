"""Lists the measurement sets of the folder for which the server was started; the page reads no set
from another folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from arctrue.base.printable import one_line
from arctrue.measurement import MeasurementError
from arctrue.measurement.description import FILE_NAME, read_description
from arctrue.measurement.reader import data_file

_DEPTH = 2
MOST_SETS = 200
_MASK = "mask.csv"


@dataclass(frozen=True)
class FoundSet:
    """A folder with a measurement.toml; ``name`` is relative to the folder for which the server was
    started."""

    name: str
    title: str
    fault: str
    """Reason why the set cannot be opened; empty if it can be opened."""


class ChosenFolder:
    """The folder for which the server was started: one measurement set, or a folder of sets."""

    def __init__(self, folder: Path) -> None:
        """Store the path of the folder as stated on the command line."""
        self.named = folder
        self._root = folder.resolve()

    @property
    def is_set(self) -> bool:
        """Whether the folder itself is a measurement set."""
        return (self._root / FILE_NAME).is_file()

    def sets(self) -> list[FoundSet]:
        """Return the sets in the folder and in two levels of folders below it, sorted by name, at
        most ``MOST_SETS``."""
        places = [self._root] if self.is_set else []
        level = [self._root]
        for _ in range(_DEPTH):
            level = [
                path
                for folder in level
                for path in _folders(folder)
                if path.resolve().is_relative_to(self._root)
            ]
            places += [path for path in level if (path / FILE_NAME).is_file()]
        return [self._found(path) for path in sorted(places)[:MOST_SETS]]

    def _found(self, path: Path) -> FoundSet:
        name = str(path.relative_to(self._root))
        try:
            title = read_description(path).keys.title
        except MeasurementError as error:
            return FoundSet(name, "", one_line(str(error)))
        return FoundSet(name, title, "")

    def path(self, name: str) -> Path:
        """Return the folder of the set with this name.

        Raises ValueError if this folder or one of its files is outside the chosen folder.
        """
        path = self._root / name
        try:
            inside = path.resolve().is_relative_to(self._root)
        except (OSError, ValueError):
            inside = False
        if not inside or not (path / FILE_NAME).is_file():
            raise ValueError(
                f"{one_line(name)[:80]}: the folder {self.named} has no such measurement set"
            )
        description = read_description(path)
        files = [path / FILE_NAME, path / _MASK]
        files += [
            file for part in ("capture", "reference") if (file := data_file(description, part))
        ]
        for file in files:
            if file.exists() and not file.resolve().is_relative_to(self._root):
                raise ValueError(
                    f"{file.name} of {one_line(name)} is a link to a file outside {self.named}, "
                    "which the page does not read: copy the file into the folder"
                )
        return path

    def as_named(self, name: str) -> str:
        """Return the set's path for a command line."""
        return str(self.named if name == "." else self.named / name)


def _folders(folder: Path) -> list[Path]:
    try:
        return sorted(
            path for path in folder.iterdir() if path.is_dir() and not path.name.startswith(".")
        )
    except OSError:
        return []
