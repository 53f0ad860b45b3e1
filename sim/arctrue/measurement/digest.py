"""Computes a digest that changes with any byte of a set's description, capture or reference run."""

from __future__ import annotations

import hashlib
from pathlib import Path

from arctrue.measurement.description import read_description
from arctrue.measurement.reader import data_file


def set_digest(folder: Path) -> str:
    """Return a SHA-256 over the SHA-256 sums of the description, the capture and the reference run.

    The value is the one that ``sha256sum measurement.toml capture.csv reference.csv | sha256sum``
    prints in the set's folder, with the file names that the description gives; files that do not
    exist are left out. Raises OSError, MeasurementError.
    """
    description = read_description(folder)
    files = [
        description.path,
        data_file(description, "capture"),
        data_file(description, "reference"),
    ]
    lines = ""
    for path in files:
        if path is not None:
            with path.open("rb") as file:
                digest = hashlib.file_digest(file, "sha256").hexdigest()
            lines += f"{digest}  {path.relative_to(folder).as_posix()}\n"
    return hashlib.sha256(lines.encode()).hexdigest()
