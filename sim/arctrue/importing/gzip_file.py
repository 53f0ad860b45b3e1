"""Unpacks files that gzip packed: a reader gets ``log.csv`` in place of ``log.csv.gz``."""

from __future__ import annotations

import gzip
import tempfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from arctrue.importing.readers.unpacked_size import refuse_above_limit
from arctrue.measurement import MeasurementError

_BLOCK = 1 << 20


def is_gzip(path: Path) -> bool:
    """Tell whether the file begins with the two magic bytes of gzip and the number of deflate,
    gzip's only method."""
    with path.open("rb") as file:
        return file.read(3) == b"\x1f\x8b\x08"


@contextmanager
def unpacked(path: Path) -> Iterator[Path]:
    """Unpack the file into a temporary file, whose name lacks the last suffix (``.gz``).

    The result exists until the context ends. Raises MeasurementError for a damaged file, and as
    soon as the output exceeds the limit.
    """
    with tempfile.TemporaryDirectory() as folder:
        unfinished = Path(folder) / (path.stem or path.name)
        size = 0
        try:
            with gzip.open(path) as packed, unfinished.open("wb") as file:
                while block := packed.read(_BLOCK):
                    # The size that the file states may be wrong, so the function counts the bytes
                    # of the output.
                    size += len(block)
                    refuse_above_limit(path, size)
                    file.write(block)
        except (EOFError, gzip.BadGzipFile, zlib.error) as error:
            raise MeasurementError("format", path, f"cannot be unpacked: {error}") from error
        yield unfinished
