"""Limits the memory into which a packed file of arrays may be unpacked.

Ten kilobytes can unpack to ten megabytes of zeros, and a header may state any number of rows. A
file that came by mail or was dropped into the page must not exhaust the machine's memory.
"""

from __future__ import annotations

from pathlib import Path

from arctrue.measurement import MeasurementError

MOST_BYTES = 2_000_000_000
"""Largest size in memory, bytes: the size of 10⁷ rows of 25 columns."""


def refuse_above_limit(path: Path, size: int) -> None:
    """Raise MeasurementError if ``size`` bytes exceed MOST_BYTES."""
    if size > MOST_BYTES:
        raise MeasurementError(
            "value",
            path,
            f"unpacks to {_in_words(size)}; expected at most {_in_words(MOST_BYTES)}: "
            "split it, or keep every second row",
        )


OBJECT_BYTES = 100
"""Bytes that Python needs for a field, or for an empty row, stored as an object."""


def refuse_many_fields(path: Path, fields: int) -> None:
    """Raise MeasurementError if ``fields`` objects need more memory than MOST_BYTES."""
    refuse_above_limit(path, fields * OBJECT_BYTES)


def _in_words(size: int) -> str:
    return f"{size / 1e9:,.3g} GB" if size >= 1e9 else f"{size / 1e6:,.3g} MB"
