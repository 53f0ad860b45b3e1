"""Divides the output of a device into lines, and finds the telemetry among the lines."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import Annotated, Any

from msgspec import Meta, Struct

from arctrue.base.typed_content import typed

LONGEST_LINE = 65_536
"""Length in bytes of the longest line that is accepted; the longest line of the firmware has 2,128
bytes."""


_Count = Annotated[int, Meta(ge=0, le=2**53)]
"""Whole number that a record can store; damage in transmission could make a number larger."""


class _TelemetryFields(Struct):
    """The fields of a line of telemetry that are shown or recorded; a line may have further
    fields."""

    turn: _Count
    result: str
    reason: str
    alarms: list[str] = []
    time_s: float | None = None
    separation_deg: float | None = None
    u_separation_arcsec: float | None = None
    residual_arcsec: float | None = None
    noise_arcsec: float | None = None
    active_arcsec: float | None = None
    candidate_arcsec: float | None = None
    loaded_arcsec: float | None = None
    temperature_c: float | None = None
    table_c: float | None = None
    swaps: _Count | None = None
    harmonics: list[tuple[_Count, float, float, float, _Count]] = []
    """Harmonics, each with order, amplitude, phase, standard uncertainty, and whether it was
    applied."""


@dataclass(frozen=True, slots=True)
class TelemetryLine:
    """One line of telemetry; ``fields`` contains all its fields."""

    fields: dict[str, Any]

    @property
    def result(self) -> str:
        """Return ``applied``, ``kept`` or ``refused``; for a line between turns return
        ``alarm``."""
        return str(self.fields["result"])


def is_telemetry(text: str) -> bool:
    """Tell whether a line is telemetry, or was telemetry before it was damaged."""
    return text.startswith("{")


def telemetry_of(text: str) -> TelemetryLine | None:
    """Return the telemetry of a line; None for a line that is not telemetry or was damaged."""
    try:
        fields = json.loads(text, parse_constant=_refuse, parse_float=_finite)
        typed(fields, _TelemetryFields)
    except (ValueError, RecursionError):
        return None
    return TelemetryLine(fields)


def _refuse(constant: str) -> None:
    raise ValueError(f"{constant} is not a number in JSON")


def _finite(number: str) -> float:
    """Convert a number of JSON; refuse one that float64 turns into infinity."""
    found = float(number)
    if not math.isfinite(found):
        raise ValueError(f"{number} does not fit into 64 bits")
    return found


class LineAssembler:
    """Joins received parts of lines to whole lines; a line longer than LONGEST_LINE is dropped."""

    def __init__(self) -> None:
        """Start with no unfinished line."""
        self._begun = b""
        self._dropping = False
        self.too_long = 0
        """Number of lines that were dropped because of their length."""

    def forget_begun(self) -> None:
        """Discard the received part of a line, for example after the port was lost."""
        self._begun, self._dropping = b"", False

    def add(self, data: bytes) -> list[str]:
        """Return the lines that ``data`` completes, without line ends and blanks around the text;
        bytes above 127 become �."""
        *ended, rest = (self._begun + data).split(b"\n")
        complete = []
        for line in ended:
            if self._dropping:
                self._dropping = False
            elif len(line) > LONGEST_LINE:
                self.too_long += 1
            else:
                complete.append(line.decode("ascii", "replace").strip())
        if len(rest) > LONGEST_LINE:
            self.too_long += not self._dropping
            self._dropping, rest = True, b""
        self._begun = rest if not self._dropping else b""
        return complete
