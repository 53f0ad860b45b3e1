"""Computes the unpacked size of a level-5 MAT file before the file is read.

A packed element of a few megabytes may hold gigabytes of zeros.
"""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

from arctrue.importing.readers.unpacked_size import refuse_above_limit
from arctrue.measurement import MeasurementError

_HEADER_BYTES = 128
_PACKED = 15
"""Number of the data type miCOMPRESSED in MathWorks' description of the format."""
_READ, _UNPACKED = 1 << 16, 1 << 20


def unpacked_bytes(path: Path) -> int:
    """Return the sum of the elements' unpacked sizes. Each packed element is unpacked once and
    discarded, because a stated size may be wrong.

    Raises MeasurementError for a damaged file, and as soon as the sum exceeds the limit.
    """
    total = 0
    end = path.stat().st_size
    with path.open("rb") as file:
        file.seek(_HEADER_BYTES - 2)
        order = "<" if file.read(2) == b"IM" else ">"
        place = _HEADER_BYTES
        while place + 8 <= end:
            file.seek(place)
            kind, length = struct.unpack(f"{order}II", file.read(8))
            place += 8 + length
            if kind != _PACKED:
                total += length
                continue
            unpacker, left = zlib.decompressobj(), min(length, end - file.tell())
            while left > 0 and not unpacker.eof:
                block = file.read(min(_READ, left))
                left -= len(block)
                while block:
                    try:
                        total += len(unpacker.decompress(block, _UNPACKED))
                    except zlib.error as error:
                        raise MeasurementError(
                            "format", path, f"cannot be read as MAT: {error}"
                        ) from error
                    refuse_above_limit(path, total)
                    block = unpacker.unconsumed_tail
    refuse_above_limit(path, total)
    return total
