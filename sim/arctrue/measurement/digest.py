"""Computes a digest that changes with any byte of a set's description, capture or reference run."""

from __future__ import annotations

import hashlib
from functools import lru_cache
from pathlib import Path

from arctrue.measurement.description import read_description
from arctrue.measurement.reader import data_file

FILES_KEPT = 1024
"""Number of files whose digests are stored, about 200 bytes each: those of 300 sets."""


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
            lines += f"{file_digest(path)}  {path.relative_to(folder).as_posix()}\n"
    return hashlib.sha256(lines.encode()).hexdigest()


def file_digest(path: Path) -> str:
    """Return the SHA-256 of a file. It is stored for further calls until the file changes. Raises
    OSError."""
    now = path.stat()
    return _digest(path, now.st_ino, now.st_size, now.st_mtime_ns, now.st_ctime_ns)


@lru_cache(maxsize=FILES_KEPT)
def _digest(path: Path, *_state: int) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
