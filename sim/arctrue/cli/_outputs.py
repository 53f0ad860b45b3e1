"""Defines the types of output paths; a path is checked before the work begins, so that no result is
lost and no measurement is overwritten."""

from __future__ import annotations

import os
import tomllib
from pathlib import Path
from typing import Any

import click

PICTURE_ENDINGS = (".svg", ".png", ".pdf")


class OutputFile(click.Path):
    """Accepts a file that can be written, in a folder that exists or that can be made."""

    def __init__(self, *endings: str) -> None:
        """Store ``endings``, the permitted endings of the file name; an empty list permits any
        ending."""
        super().__init__(dir_okay=False, writable=True, path_type=Path)
        self._endings = endings

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Return the path. Fails with a reason if the file cannot be written."""
        path = Path(os.fsdecode(super().convert(value, param, ctx)))
        if self._endings and path.suffix.lower() not in self._endings:
            known = ", ".join(self._endings)
            self.fail(f"{path}: expected a name that ends in {known}.", param, ctx)
        for fault_of in (_name_fault, _file_fault):
            if fault := fault_of(path):
                self.fail(fault, param, ctx)
        if fault := _folder_fault(path.parent):
            self.fail(fault, param, ctx)
        return path


class OutputFolder(click.Path):
    """Accepts a folder that exists or that can be made, and in which files can be written."""

    def __init__(self) -> None:
        """Create the type for a folder with any name."""
        super().__init__(file_okay=False, path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Return the folder. Fails with a reason if no file can be written to it."""
        folder = Path(os.fsdecode(super().convert(value, param, ctx)))
        if fault := _folder_fault(folder):
            self.fail(fault, param, ctx)
        return folder


def near(path: Path) -> Path:
    """Return a path below the current folder relative to that folder; any other path unchanged."""
    here = Path.cwd()
    return path.relative_to(here) if path.is_relative_to(here) else path


def _name_fault(path: Path) -> str | None:
    """Return the reason why no file or folder can have this name; None if one can have it."""
    try:
        path.exists()
    except OSError as error:
        return f"'{path}': {error.strerror}; name another place."
    return None


def _file_fault(path: Path) -> str | None:
    """Return the reason why no result may be written to this file; None if one may."""
    if str(path) == "-":
        return "'-' is not a file name; the command writes this result only to a file."
    if not path.exists():
        return None
    if not path.is_file():
        return f"'{path}' is not an ordinary file; name another file."
    if path.name in _files_of_a_set(path.parent):
        return f"'{path}' belongs to the measurement set '{path.parent}'; name another file."
    return None


def _files_of_a_set(folder: Path) -> set[str]:
    """Return the names of the files of a measurement set; an empty set if the folder holds none."""
    description = folder / "measurement.toml"
    if not description.is_file():
        return set()
    found = {description.name, "mask.csv", "capture.csv", "reference.csv"}
    try:
        tables = tomllib.loads(description.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return found  # the command that reads the set reports the fault of the file
    entries = [table.get("file") for table in tables.values() if isinstance(table, dict)]
    return found | {name for name in entries if isinstance(name, str)}


def refuse_to_replace(kept: Path) -> None:
    """Raise UsageError if an output option of the present command names this file, which the
    command reads."""
    context = click.get_current_context(silent=True)
    if context is None:
        return
    for parameter in context.command.params:
        path = context.params.get(parameter.name or "")
        if (
            isinstance(parameter.type, OutputFile)
            and isinstance(path, Path)
            and path.resolve() == kept.resolve()
        ):
            raise click.UsageError(
                f"{parameter.opts[0]}: '{path}' is the model that the command reads; "
                "name another file.",
                context,
            )


def _folder_fault(folder: Path) -> str | None:
    """Return the reason why no file can be written to ``folder``; None if the folder is writable or
    can be made."""
    if fault := _name_fault(folder):
        return fault
    there = next(place for place in (folder, *folder.absolute().parents) if place.exists())
    if not there.is_dir():
        return f"'{there}' is a file; name a folder."
    if not os.access(there, os.W_OK | os.X_OK):
        return f"Nothing can be written to '{there}'; name another place."
    return None
