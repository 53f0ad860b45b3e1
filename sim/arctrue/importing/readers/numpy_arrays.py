"""NumPy files: one array (.npy) or several (.npz)."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from arctrue.importing.choices import Choices
from arctrue.importing.reader import ReadSettings
from arctrue.importing.readers.arrays import recording_of
from arctrue.importing.recording import Recording
from arctrue.measurement import MeasurementError


def recognises(path: Path, head: bytes) -> bool:
    """True for the magic of .npy, and for a .npz archive."""
    return head.startswith(b"\x93NUMPY") or (
        head.startswith(b"PK\x03\x04") and path.suffix.lower() == ".npz"
    )


def read(path: Path, settings: ReadSettings, choices: Choices) -> Recording:
    """Columns of an array (rows, columns), of a structured array, or the arrays of an archive.

    Raises MeasurementError for a damaged file, pickled objects (never unpickled) and arrays that
    are no columns.
    """
    try:
        loaded = np.load(path, allow_pickle=False)
        if isinstance(loaded, np.ndarray):
            return recording_of(path, "numpy", {"": loaded})
        with loaded:
            return recording_of(path, "numpy", {name: loaded[name] for name in loaded.files})
    except MeasurementError:
        raise
    except (ValueError, EOFError, zipfile.BadZipFile) as error:
        raise MeasurementError("format", path, f"cannot be read as NumPy: {error}") from error
