"""The PVs of a device: which field of the telemetry each shows, with unit and limits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

MOST_ORDERS = 128
NO_ALARM, MINOR, MAJOR, INVALID = 0, 1, 2, 3
"""Severities of EPICS."""
STATE, COMM = 7, 9
"""Alarm status of EPICS: of the state; no communication."""
CAPTURE = "Capture"


@dataclass(frozen=True, slots=True)
class NumberRecord:
    """A number of the telemetry as an analogue input."""

    name: str
    field: str
    fields: dict[str, Any]
    """Fields of the EPICS record: unit, decimals, display limits, alarm limits."""


NUMBERS = (
    NumberRecord("HeadSeparation", "separation_deg", {"EGU": "deg", "PREC": 6}),
    NumberRecord("HeadSeparationU", "u_separation_arcsec", {"EGU": "arcsec", "PREC": 4}),
    NumberRecord("Noise", "noise_arcsec", {"EGU": "arcsec", "PREC": 4}),
    NumberRecord("Residual", "residual_arcsec", {"EGU": "arcsec", "PREC": 4}),
    NumberRecord("ErrorActive", "active_arcsec", {"EGU": "arcsec", "PREC": 4}),
    NumberRecord("ErrorLoaded", "loaded_arcsec", {"EGU": "arcsec", "PREC": 4}),
    NumberRecord(
        "DieTemperature",
        "temperature_c",
        # The range of the XC7Z020: 85 °C is also the preset of the device's own alarm.
        {"EGU": "degC", "PREC": 2, "LOPR": 0, "HOPR": 100}
        | {"HIGH": 85, "HSV": "MINOR", "HIHI": 100, "HHSV": "MAJOR"},
    ),
    NumberRecord("TableTemperature", "table_c", {"EGU": "degC", "PREC": 3, "LOPR": 0, "HOPR": 50}),
    NumberRecord("DeviceTime", "time_s", {"EGU": "s", "PREC": 3}),
)
ARRAYS = {"Orders": 0, "Amplitudes": 1, "Phases": 2, "Uncertainties": 3, "Applied": 4}
"""Waveforms, and the place of each in a harmonic of the telemetry."""
ARRAY_UNITS = {"Amplitudes": "arcsec", "Phases": "rad", "Uncertainties": "arcsec"}
ACCESS = "ASG(DEFAULT) {{ RULE(1, READ) }}\nASG(CONTROL) {{ RULE(1, READ) RULE(1, {control}) }}\n"


def access_text(*, allow_control: bool) -> str:
    """The file of EPICS access security: nobody writes, or anybody writes the control PVs."""
    return ACCESS.format(control="WRITE" if allow_control else "READ")


class Records:
    """The PVs of one device. softioc is imported here: its variables must be set before."""

    def __init__(self, prefix: str, capture: Callable[[], object]) -> None:
        """Make the records; ``capture`` is called when a client writes to the PV Capture."""
        from softioc import builder

        self._numbers = {
            item.field: builder.aIn(f"{prefix}{item.name}", **item.fields) for item in NUMBERS
        }
        self._turn = builder.longIn(f"{prefix}Turn")
        self._result = builder.stringIn(f"{prefix}Result")
        self._reason = builder.stringIn(f"{prefix}Reason")
        self._alarms = builder.longStringIn(f"{prefix}Alarms", length=512)
        self._connected = builder.boolIn(f"{prefix}Connected", ZNAM="lost", ONAM="open")
        self._arrays = {
            name: builder.WaveformIn(
                f"{prefix}{name}", length=MOST_ORDERS, datatype=float, EGU=ARRAY_UNITS.get(name, "")
            )
            for name in ARRAYS
        }

        def asked(value: int) -> None:
            if value:
                capture()

        builder.boolOut(
            f"{prefix}{CAPTURE}", ZNAM="no", ONAM="capture", ASG="CONTROL", on_update=asked
        )
        builder.LoadDatabase()

    def show(self, fields: dict[str, Any], recorded_s: float) -> None:
        """Show one line of telemetry with the time at which it was recorded.

        A number that the device did not send, and everything of a refused turn, is INVALID.
        """
        at: dict[str, Any] = {"timestamp": recorded_s}
        alarms = fields.get("alarms", [])
        severity = {"severity": MAJOR, "alarm": STATE} if alarms else {}
        self._alarms.set(", ".join(alarms), **at, **severity)
        if fields["result"] == "alarm":
            return  # a line between turns has alarms alone
        refused = {"severity": MINOR, "alarm": STATE} if fields["result"] == "refused" else {}
        self._result.set(str(fields["result"])[:39], **at, **refused)
        self._reason.set(str(fields["reason"])[:39], **at, **refused)
        for field, record in self._numbers.items():
            value = fields.get(field)
            if value is None:
                record.set(record.get(), severity=INVALID, alarm=STATE, **at)
            else:
                record.set(float(value), **at)
        harmonics = fields.get("harmonics", [])[:MOST_ORDERS]
        for name, place in ARRAYS.items():
            if harmonics:
                self._arrays[name].set([float(h[place]) for h in harmonics], **at)
        # Last: a client that waits for the next turn then reads the others of the same turn.
        self._turn.set(int(fields["turn"]) % 2**31, **at)

    def connected(self, is_connected: bool, recorded_s: float) -> None:
        """Show whether the device can be reached; without it every value is INVALID."""
        at: dict[str, Any] = {"timestamp": recorded_s}
        if is_connected:
            self._connected.set(1, **at)
            return
        lost: dict[str, Any] = {"severity": INVALID, "alarm": COMM, **at}
        self._connected.set(0, severity=MAJOR, alarm=COMM, **at)
        others = (self._turn, self._result, self._reason, self._alarms)
        for record in (*self._numbers.values(), *self._arrays.values(), *others):
            record.set(record.get(), **lost)
