"""Checks the alarms of a machine's history, which ``arctrue life`` sends, and keeps them in a
file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import msgspec

from arctrue.base.whole_file import write_whole_text

_Name = Annotated[str, msgspec.Meta(min_length=1, max_length=200)]
_Text = Annotated[str, msgspec.Meta(max_length=1000)]
_Alarms = Annotated[dict[_Name, _Text], msgspec.Meta(max_length=100)]


def checked_machine_alarms(alarms: Any) -> dict[str, str]:
    """Return the alarms of a request, a sentence for each parameter. Raises ValueError."""
    try:
        return msgspec.convert(alarms, _Alarms)
    except msgspec.ValidationError as error:
        raise ValueError(str(error)) from error


def read_machine_alarms(file: Path) -> dict[str, str]:
    """Return the alarms that an earlier daemon kept; the mapping is empty if the file is missing or
    damaged."""
    try:
        return msgspec.json.decode(file.read_bytes(), type=_Alarms)
    except (OSError, msgspec.MsgspecError):
        return {}


def write_machine_alarms(file: Path, alarms: dict[str, str]) -> None:
    """Write the alarms to the file, for a later daemon. Raises OSError."""
    write_whole_text(file, msgspec.json.encode(alarms).decode())
