"""Defines the process variables (PVs) of a device for EPICS, with telemetry field, unit, limits."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any

from arctrue.device.port import ConsoleError

MOST_ORDERS = 128
NO_ALARM, MINOR, MAJOR, INVALID = 0, 1, 2, 3
"""EPICS alarm severities."""
STATE, COMM = 7, 9
"""EPICS alarm states: STATE for the state of the device, COMM for no communication."""
ZERO = "Zero"
"""Name of the PV with the angle at the index, which is added to the angles of events. A motor
record may write this PV after its homing."""
CAPTURE = "Capture"
_TIME_OF_VALUE = -2
"""Value of the field TSE of an EPICS record: the program supplies the time together with the
value."""


@dataclass(frozen=True, slots=True)
class NumberRecord:
    """A number of the telemetry or of an event ``probe`` that becomes an EPICS record."""

    name: str
    field: str
    fields: dict[str, Any]
    """Fields of the EPICS record: unit, decimals, display limits and alarm limits."""


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
        # The limits are the range of the XC7Z020; 85 °C is also the preset of the device's own
        # alarm.
        {"EGU": "degC", "PREC": 2, "LOPR": 0, "HOPR": 100}
        | {"HIGH": 85, "HSV": "MINOR", "HIHI": 100, "HHSV": "MAJOR"},
    ),
    NumberRecord("TableTemperature", "table_c", {"EGU": "degC", "PREC": 3, "LOPR": 0, "HOPR": 50}),
    NumberRecord("DeviceTime", "time_s", {"EGU": "s", "PREC": 3}),
)
PROBE = (
    NumberRecord("ProbeEdge", "edge", {}),
    NumberRecord("ProbeMissed", "missed", {}),
    NumberRecord("ProbeTime", "time_s", {"EGU": "s", "PREC": 9}),
    NumberRecord("ProbePosition", "position_counts", {"EGU": "counts"}),
    NumberRecord("ProbeAngle", "angle_deg", {"EGU": "deg", "PREC": 7}),
    NumberRecord("ProbeKind", "kind", {}),
)
"""PVs of one event ``probe``."""
MOST_EVENTS = 64
PROBE_ARRAYS = (
    NumberRecord("ProbeEdges", "edge", {}),
    NumberRecord("ProbeTimes", "time_s", {"EGU": "s"}),
    NumberRecord("ProbePositions", "position_counts", {"EGU": "counts"}),
    NumberRecord("ProbeAngles", "angle_deg", {"EGU": "deg"}),
    NumberRecord("ProbeKinds", "kind", {}),
)
"""Waveform PVs of the latest MOST_EVENTS events ``probe``, the latest event last."""
ARRAYS = {"Orders": 0, "Amplitudes": 1, "Phases": 2, "Uncertainties": 3, "Applied": 4}
"""Waveform PVs of the harmonics, with the index of each value in a harmonic of the telemetry."""
ARRAY_UNITS = {"Amplitudes": "arcsec", "Phases": "rad", "Uncertainties": "arcsec"}
ACCESS = "ASG(DEFAULT) {{ RULE(1, READ) }}\nASG(CONTROL) {{ RULE(1, READ) RULE(1, {control}) }}\n"


def access_text(*, allow_control: bool) -> str:
    """Return the EPICS access security file with which all PVs are read-only, or control PVs are
    writable."""
    return ACCESS.format(control="WRITE" if allow_control else "READ")


class Records:
    """The PVs of one device. softioc is imported in the methods, because its environment variables
    must be set first."""

    def __init__(
        self,
        prefix: str,
        capture: Callable[[], Awaitable[str]],
        keep_zero: Callable[[float], Awaitable[None]],
    ) -> None:
        """Make the EPICS records.

        ``capture``, which is called when a client writes to the PV Capture, takes a capture and
        returns the set's folder. The text of its ConsoleError becomes the PV CaptureFault.
        ``keep_zero`` gets each value that a client writes to the PV Zero, degrees.
        """
        from softioc import builder

        # Each PV has the time at which the daemon recorded the value, not the time of the record's
        # processing.
        of_daemon = {"TSE": _TIME_OF_VALUE}
        self._numbers = {
            item.field: builder.aIn(f"{prefix}{item.name}", **item.fields, **of_daemon)
            for item in NUMBERS
        }
        self._turn = builder.longIn(f"{prefix}Turn", **of_daemon)
        self._result = builder.stringIn(f"{prefix}Result", **of_daemon)
        self._reason = builder.stringIn(f"{prefix}Reason", **of_daemon)
        self._alarms = builder.longStringIn(f"{prefix}Alarms", length=512, **of_daemon)
        self._connected = builder.boolIn(
            f"{prefix}Connected", ZNAM="lost", ONAM="open", **of_daemon
        )
        self._capture_set = builder.longStringIn(f"{prefix}CaptureSet", length=1024, **of_daemon)
        self._capture_fault = builder.longStringIn(f"{prefix}CaptureFault", length=512, **of_daemon)
        self._probe = {
            item.field: builder.aIn(f"{prefix}{item.name}", **item.fields, **of_daemon)
            for item in PROBE
        }
        self._probe_arrays = {
            item.field: builder.WaveformIn(
                f"{prefix}{item.name}",
                length=MOST_EVENTS,
                datatype=float,
                **item.fields,
                **of_daemon,
            )
            for item in PROBE_ARRAYS
        }
        self._edge: tuple[dict[str, Any], float] | None = None
        self._edges: deque[dict[str, Any]] = deque(maxlen=MOST_EVENTS)

        async def zeroed(value: float) -> None:
            self._show_edge()
            await keep_zero(float(value))

        # Blocking: a client's write is complete only when the daemon has kept the zero, or when no
        # daemon has answered.
        self._zero = builder.aOut(
            f"{prefix}{ZERO}",
            EGU="deg",
            PREC=7,
            ASG="CONTROL",
            initial_value=0.0,
            on_update=zeroed,
            blocking=True,
        )
        self._latest: tuple[dict[str, Any], float] | None = None
        self._device_alarms: list[str] = []
        self._machine_alarms: list[str] = []
        self._arrays = {
            name: builder.WaveformIn(
                f"{prefix}{name}",
                length=MOST_ORDERS,
                datatype=float,
                EGU=ARRAY_UNITS.get(name, ""),
                **of_daemon,
            )
            for name in ARRAYS
        }

        async def asked(value: int) -> None:
            if value:
                await self._take_capture(capture)

        # The record is blocking: a client's write is complete only when the capture is complete.
        builder.boolOut(
            f"{prefix}{CAPTURE}",
            ZNAM="no",
            ONAM="capture",
            ASG="CONTROL",
            on_update=asked,
            always_update=True,
            blocking=True,
        )
        builder.LoadDatabase()

    def show(self, fields: dict[str, Any], recorded_s: float) -> None:
        """Set the PVs to one line of telemetry with the time at which it was recorded.

        A number that the device did not send is INVALID. After a refused turn, Result and Reason
        have the severity MINOR. The waveforms keep their values if the device sent no harmonics.
        """
        at: dict[str, Any] = {"timestamp": recorded_s}
        self._device_alarms = list(fields.get("alarms", []))
        self._show_alarms(recorded_s)
        if fields["result"] == "alarm":
            return  # a line between turns contains only alarms
        self._latest = (fields, recorded_s)
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
        # The PV of the turn is set last; a client that waits for the next turn then reads all
        # values of this turn.
        self._turn.set(int(fields["turn"]) % 2**31, **at)

    def edge(self, event: dict[str, Any], recorded_s: float) -> None:
        """Set the PVs to the table's position at an edge of probe_in or a pulse of compare_out,
        with the time of recording."""
        self._edge = (event, recorded_s)
        self._edges.append(event)
        self._show_edge()

    def _show_edge(self) -> None:
        """Set the waveforms to the latest events; the PV Zero is added to their angles."""
        if self._edge is None:
            return
        event, recorded_s = self._edge
        zero = {"angle_deg": float(self._zero.get())}
        for field, array in self._probe_arrays.items():
            values = [float(edge[field]) + zero.get(field, 0.0) for edge in self._edges]
            array.set(values, timestamp=recorded_s)
        # These PVs are set last; a client that waits for the next event then finds it in the
        # waveforms.
        for field, record in self._probe.items():
            record.set(float(event[field]) + zero.get(field, 0.0), timestamp=recorded_s)

    def zero(self, zero_deg: float) -> None:
        """Set the PV Zero to the angle at the index that the daemon keeps, degrees."""
        self._zero.set(zero_deg, process=False)
        self._show_edge()

    def machine_alarms(self, names: list[str], recorded_s: float) -> None:
        """Set the PV of the alarms: first the device's own alarms, then the parameters with an
        alarm of ``arctrue life``."""
        self._machine_alarms = [f"life: {name}" for name in names]
        self._show_alarms(recorded_s)

    def _show_alarms(self, recorded_s: float) -> None:
        alarms = [*self._device_alarms, *self._machine_alarms]
        severity = {"severity": MAJOR, "alarm": STATE} if alarms else {}
        self._alarms.set(", ".join(alarms)[:511], timestamp=recorded_s, **severity)

    async def _take_capture(self, capture: Callable[[], Awaitable[str]]) -> None:
        try:
            folder = await capture()
        except ConsoleError as error:
            failed: dict[str, Any] = {"severity": MAJOR, "alarm": STATE}
            self._capture_fault.set(str(error)[:511], timestamp=time.time(), **failed)
            return
        self._capture_set.set(folder, timestamp=time.time())
        self._capture_fault.set("", timestamp=time.time())

    def connected(self, is_connected: bool, recorded_s: float) -> None:
        """Set Connected to 1 if the device can be reached, otherwise to 0; every value of the
        device then has the severity INVALID.

        After a reconnection the latest turn is set again, with its own time, before Connected is
        set: a client that waits for Connected then finds no value that is still INVALID.
        """
        at: dict[str, Any] = {"timestamp": recorded_s}
        if is_connected:
            if self._latest is not None:
                self.show(*self._latest)
            self._show_edge()
            self._show_alarms(recorded_s)
            self._connected.set(1, **at)
            return
        lost: dict[str, Any] = {"severity": INVALID, "alarm": COMM, **at}
        self._connected.set(0, severity=MAJOR, alarm=COMM, **at)
        others = (self._turn, self._result, self._reason, self._alarms)
        numbers = (*self._numbers.values(), *self._probe.values())
        arrays = (*self._arrays.values(), *self._probe_arrays.values())
        for record in (*numbers, *arrays, *others):
            record.set(record.get(), **lost)
