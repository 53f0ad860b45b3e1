"""Reads NumPy files: one array (.npy) or several (.npz)."""

from __future__ import annotations

import math
import zipfile
from pathlib import Path
from typing import IO

import numpy as np

from arctrue.importing.choices import Choices
from arctrue.importing.file_content import FileContent
from arctrue.importing.reader import ReadSettings
from arctrue.importing.readers.arrays import recording_of
from arctrue.importing.readers.unpacked_size import refuse_above_limit
from arctrue.measurement import MeasurementError

MAGIC = np.lib.format.MAGIC_PREFIX


def recognises(path: Path, head: bytes) -> bool:
    """Tell whether the file begins with the magic bytes of .npy, or is a .npz archive (ZIP)."""
    return head.startswith(MAGIC) or (
        head.startswith(b"PK\x03\x04") and path.suffix.lower() == ".npz"
    )


def read(path: Path, settings: ReadSettings, choices: Choices) -> FileContent:
    """Return the columns of an array (rows, columns), of a structured array, or of an archive's
    arrays.

    Raises MeasurementError for a damaged file, for pickled objects (never unpickled), for arrays
    that are not columns, and for a size above the limit.
    """
    try:
        refuse_above_limit(path, _unpacked_bytes(path))
        loaded = np.load(path, allow_pickle=False)
        if isinstance(loaded, np.ndarray):
            return recording_of(path, "numpy", {"": loaded})
        with loaded:
            return recording_of(path, "numpy", {name: loaded[name] for name in loaded.files})
    except MeasurementError:
        raise
    except (ValueError, EOFError, zipfile.BadZipFile) as error:
        raise MeasurementError("format", path, f"cannot be read as NumPy: {error}") from error


def _unpacked_bytes(path: Path) -> int:
    """Return the sum of the sizes that the arrays' headers state, because numpy allocates this
    memory before it reads."""
    if not zipfile.is_zipfile(path):
        with path.open("rb") as file:
            return _array_bytes(file)
    total = 0
    with zipfile.ZipFile(path) as archive:
        for item in archive.infolist():
            with archive.open(item) as file:
                total += max(item.file_size, _array_bytes(file))
    return total


def _array_bytes(file: IO[bytes]) -> int:
    """Return the size that the array's header states; 0 without a header, because numpy refuses
    such a file."""
    if file.read(len(MAGIC)) != MAGIC:
        return 0
    file.seek(0)
    version = np.lib.format.read_magic(file)
    read_header = (
        np.lib.format.read_array_header_1_0
        if version == (1, 0)
        else np.lib.format.read_array_header_2_0
    )
    shape, _, dtype = read_header(file)
    return math.prod(shape) * dtype.itemsize
