"""The limit of what a packed file of arrays may unpack to.

Ten kilobytes of zeros unpack to ten megabytes, and a header may tell any number of rows: a file
that was sent by mail or dropped into the page must not take the memory of the machine.
"""

from __future__ import annotations

from pathlib import Path

from arctrue.measurement import MeasurementError

MOST_BYTES = 2_000_000_000
"""10⁷ rows of 25 columns."""


def refuse_above_limit(path: Path, size: int) -> None:
    """Raise MeasurementError where ``size`` bytes are more than MOST_BYTES."""
    if size > MOST_BYTES:
        raise MeasurementError(
            "value",
            path,
            f"unpacks to {_told(size)}; expected at most {_told(MOST_BYTES)}: "
            "split it, or keep every second row",
        )


OBJECT_BYTES = 100
"""Of a field, or of a row without one, that Python holds as an object of its own."""


def refuse_many_fields(path: Path, fields: int) -> None:
    """Raise MeasurementError where ``fields`` objects take more than MOST_BYTES."""
    refuse_above_limit(path, fields * OBJECT_BYTES)


def _told(size: int) -> str:
    return f"{size / 1e9:,.3g} GB" if size >= 1e9 else f"{size / 1e6:,.3g} MB"
