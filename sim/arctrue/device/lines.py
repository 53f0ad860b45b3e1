"""Splits the output of a device into lines and finds the telemetry among them."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Annotated, Any

from msgspec import Meta, Struct

from arctrue.base.typed_content import typed

LONGEST_LINE = 65_536
"""Longest line that is accepted, bytes; the longest line of the firmware has 2,128."""


_Count = Annotated[int, Meta(ge=0, le=2**53)]
"""Whole number that a record can store; a damaged digit could give a larger one."""


class _TelemetryFields(Struct):
    """The fields that are shown or recorded; a line may have further ones."""

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
    """Order, amplitude, phase, standard uncertainty, whether it was applied."""


@dataclass(frozen=True, slots=True)
class TelemetryLine:
    """One line of telemetry; ``fields`` contains all its fields."""

    fields: dict[str, Any]

    @property
    def result(self) -> str:
        """Return ``applied``, ``kept`` or ``refused``; ``alarm`` for a line between turns."""
        return str(self.fields["result"])


def is_telemetry(text: str) -> bool:
    """Tell whether a line is telemetry, or was telemetry before it was damaged."""
    return text.startswith("{")


def telemetry_of(text: str) -> TelemetryLine | None:
    """Read a line of telemetry; None for a line that was damaged on the way."""
    try:
        fields = json.loads(text, parse_constant=_refuse)
        typed(fields, _TelemetryFields)
    except (ValueError, RecursionError):
        return None
    return TelemetryLine(fields)


def _refuse(constant: str) -> None:
    raise ValueError(f"{constant} is no number of JSON")


class LineAssembler:
    """Joins the parts of lines as they arrive; drops a line that is longer than LONGEST_LINE."""

    def __init__(self) -> None:
        """Start without any part of a line."""
        self._begun = b""
        self._dropping = False
        self.too_long = 0
        """Number of lines that were dropped because of their length."""

    def forget_begun(self) -> None:
        """Drop the part of a line that has arrived, for example after the port was lost."""
        self._begun, self._dropping = b"", False

    def add(self, data: bytes) -> list[str]:
        """Return the lines that ``data`` completes, without their ends; bytes over 127 become �."""
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
