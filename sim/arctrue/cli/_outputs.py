"""Defines the types of output paths; a path is checked before the work begins, so that no result is
lost."""

from __future__ import annotations

import os
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
        if fault := _name_fault(path) or _folder_fault(path.parent):
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


def _name_fault(path: Path) -> str | None:
    """Return the reason why no file or folder can have this name; None if one can have it."""
    try:
        path.exists()
    except OSError as error:
        return f"'{path}': {error.strerror}; name another place."
    return None


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
