"""Reads and writes the sealed truth: the hidden causes of a measurement set, in a file next to the
set's folder."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from msgspec import Struct

from arctrue.base.typed_content import read_json, typed
from arctrue.base.whole_file import write_whole_text
from arctrue.measurement.description import FILE_NAME

READ_ONLY = 0o444


class _Sealed(Struct):
    seal: dict[str, str]


class BrokenSealError(ValueError):
    """Raised if the measurement set has changed since its truth was sealed."""


def truth_path(folder: Path) -> Path:
    """Return the path ``OUT.truth.json`` next to the folder ``OUT``."""
    folder = folder.resolve()
    return folder.with_name(folder.name + ".truth.json")


def fingerprint(folder: Path) -> dict[str, str]:
    """Return the SHA-256 digest of every file of the set, by file name."""
    return {
        file.name: hashlib.sha256(file.read_bytes()).hexdigest()
        for file in sorted(folder.iterdir())
        if file.is_file()
    }


def refuse_recorded(folder: Path) -> None:
    """Raise ValueError if ``folder`` holds a set without a truth file.

    Such a set was not simulated, but recorded or imported; a simulated set would overwrite it.
    """
    if (folder / FILE_NAME).exists() and not truth_path(folder).exists():
        raise ValueError(f"{folder}: holds a measurement set already; name a new folder")


def write_truth(folder: Path, truth: dict[str, Any]) -> Path:
    """Write ``truth`` with the fingerprint of the set in ``folder``."""
    path = truth_path(folder)
    sealed = {**truth, "seal": fingerprint(folder)}
    write_whole_text(path, json.dumps(sealed, indent=1, ensure_ascii=False) + "\n")
    path.chmod(READ_ONLY)
    return path


def read_truth(folder: Path) -> dict[str, Any]:
    """Read the truth of the set in ``folder``.

    Raises FileNotFoundError without a truth file, ContentError for a file that is no truth, and
    BrokenSealError if the set has changed.
    """
    path = truth_path(folder)
    truth = read_json(path, dict[str, Any])
    if typed(truth, _Sealed, str(path)).seal != fingerprint(folder):
        raise BrokenSealError(f"{folder} was changed after {path} was written; simulate it again")
    return truth
