"""Follows the daemon of a device in a thread; the page shows the received data live."""

from __future__ import annotations

import threading
import time
from collections import deque
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from arctrue.base.units import ARCSEC_PER_DEG
from arctrue.calibration.axis_orbit import AxisOrbit, orbit_of_set
from arctrue.calibration.capture_check import CaptureRefusedError
from arctrue.device.announcement import Announcement
from arctrue.device.changes import calibration_turn, changes_since, order_change
from arctrue.device.connection import Watch, ask, daemon_of
from arctrue.device.console import ConsoleError
from arctrue.measurement import MeasurementError, read_measurement_set
from arctrue.metrology.iso230_7 import error_motion

_MOST_TURNS = 2_000
_MOST_POINTS = 400
"""Largest number of turns in a chart; if there are more, only every second, third, … turn is
drawn."""
_MOST_ORDERS = 6
"""Number of orders in the chart of orders, which shows the largest ratios of change to standard
uncertainty."""
_MOST_EVENTS = 20
_MOST_SAMPLES = 1_500
"""Largest number of samples in the chart of the axis orbit."""
_DECIMALS = 4
"""Number of decimals of the orbit's samples, arcseconds."""
_AGAIN_S = 1.0
_EVENT_S = 2.0
_CAPTURE_S = 400.0


class LiveDevice:
    """Holds the latest turns and events of a device. ``port``: serial port of the device, or
    HOST:PORT of its daemon."""

    def __init__(self, port: str) -> None:
        """Start the thread that follows the daemon; while no daemon is running, the thread searches
        for it each second."""
        self.port = port
        self._turns: deque[dict[str, Any]] = deque(maxlen=_MOST_TURNS)
        self._events: deque[dict[str, Any]] = deque(maxlen=_MOST_EVENTS)
        self._connected, self._alarms = False, list[str]()
        self._machine_alarms: list[str] = []
        self._captured = ""
        self._orbit: dict[str, Any] | None = None
        self._problem = f"{port}: no daemon runs; start it with arctrue device run"
        self._lock = threading.Lock()
        threading.Thread(target=self._keep_following, daemon=True).start()

    def capture(self) -> Path:
        """Capture a turn and return the folder of its measurement set. Raises ConsoleError,
        OSError."""
        daemon = daemon_of(self.port)
        if daemon is None:
            raise ConsoleError(f"{self.port}: no daemon runs; start it with arctrue device run")
        path = Path(ask(daemon, "capture", _CAPTURE_S)["capture"])
        if not path.is_dir():
            raise ConsoleError(f"the daemon wrote {path}, which is on another machine")
        return path

    def shown(self) -> dict[str, Any]:
        """Return all values that the page shows, as values for JSON."""
        with self._lock:
            turns, events = list(self._turns), list(self._events)
            found = {
                "problem": self._problem,
                "connected": self._connected and not self._problem,
                "alarms": list(self._alarms),
                "machine_alarms": list(self._machine_alarms),
                "orbit": self._orbit,
            }
        found["events"] = [{**event, "time": _utc(event["recorded_s"])} for event in events]
        return found | ({"turn": None} if not turns else _history(turns))

    def _keep_following(self) -> None:
        while True:
            problem = f"{self.port}: no daemon runs; start it with arctrue device run"
            try:
                daemon = daemon_of(self.port)
                if daemon is not None:
                    self._follow(daemon)
            except ConsoleError as error:
                problem = str(error)
            with self._lock:
                self._problem = problem
            time.sleep(_AGAIN_S)

    def _follow(self, daemon: Announcement) -> None:
        """Receive the daemon's events until the daemon ends. Raises ConsoleError."""
        state = ask(daemon, "status")
        watch = Watch(daemon, latest=_MOST_TURNS)
        with self._lock:
            self._turns.clear()
            self._problem = ""
            self._alarms = list(state["alarms"])
            self._take_state(state)
        try:
            while True:
                event = watch.event(_EVENT_S)
                if event is not None:
                    with self._lock:
                        self._take(event)
        finally:
            watch.close()

    def _take(self, event: dict[str, Any]) -> None:
        if event["event"] == "probe":
            return
        if event["event"] != "turn":
            self._take_state(event["state"])
            shown = {"kind": event["event"], "text": event["text"]}
            self._events.append({**shown, "recorded_s": event["recorded_s"]})
            return
        fields = event["telemetry"]
        self._alarms = list(fields.get("alarms", []))
        if fields["result"] != "alarm":
            self._turns.append({**fields, "recorded_s": event["recorded_s"]})

    def _take_state(self, state: dict[str, Any]) -> None:
        self._connected = bool(state["connected"])
        self._machine_alarms = list(state["machine_alarms"].values())
        path = str(state.get("latest_capture", ""))
        if path and path != self._captured:
            self._captured = path
            threading.Thread(target=self._find_orbit, args=(Path(path),), daemon=True).start()

    def _find_orbit(self, path: Path) -> None:
        """Compute the axis orbit from a capture, if the heads of the device determine it."""
        try:
            measurement = read_measurement_set(path)
            orbit = orbit_of_set(measurement)
        except (CaptureRefusedError, MeasurementError, OSError, ValueError):
            orbit = None
        if orbit is None or not orbit.has_synchronous:
            return
        assert measurement.capture is not None
        columns = _orbit_columns(orbit)
        with self._lock:
            self._orbit = {**columns, "set": path.name, "heads": len(measurement.capture.heads)}


def _history(turns: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the latest turn, the changes since calibration and first turn, and the charts'
    columns."""
    # The telemetry of a refused turn contains no orders.
    estimated = [turn for turn in turns if turn.get("harmonics")] or turns
    before, now = estimated[calibration_turn(estimated)], estimated[-1]
    drawn = turns[:: -max(-(-len(turns) // _MOST_POINTS), 1)][::-1]
    separation = now.get("separation_deg")
    return {
        "turn": turns[-1],
        "heads": _heads(turns),
        "recorded": _utc(turns[-1]["recorded_s"]),
        "since": {
            "calibration": _comparison(drawn, before, now),
            "first": _comparison(drawn, estimated[0], now),
        },
        "charts": {
            "time": [_utc(turn["recorded_s"], "milliseconds") for turn in drawn],
            "separation": [
                None
                if turn.get("separation_deg") is None or separation is None
                else ARCSEC_PER_DEG
                * (turn["separation_deg"] - (before.get("separation_deg") or 0.0))
                for turn in drawn
            ],
            "u_separation": [turn.get("u_separation_arcsec") for turn in drawn],
            "die": [turn.get("temperature_c") for turn in drawn],
            "table": [turn.get("table_c") for turn in drawn],
            "axis": _axis_columns(drawn),
        },
    }


def _heads(turns: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the results for each head and for the axis. They come from the latest turn in which
    the device calibrated the mean of the heads or, if there is none, from the latest turn with
    delays of the heads. The left-out heads and the parity come from the latest turn."""
    keys = ("places_deg", "late_ns")
    now = next((turn for key in keys for turn in reversed(turns) if turn.get(key)), None)
    if now is None:
        return {"rows": [], "axis": []}
    out = turns[-1].get("left_out", [])
    heads = max(len(now.get(key, [])) for key in keys)
    columns = [
        [*now.get(key, []), *[None] * heads][:heads]
        for key in (
            *("places_deg", "u_places_arcsec", "radii", "u_radii"),
            *("late_ns", "head_residual_arcsec"),
        )
    ]
    rows = [
        [head, *values, "left out" if head in out else "in use"]
        for head, values in enumerate(zip(*columns, strict=True), start=1)
    ]
    circles = zip(
        now.get("axis_forward_arcsec", []), now.get("axis_backward_arcsec", []), strict=True
    )
    axis = [[order, *pair] for order, pair in enumerate(circles, start=1)]
    return {
        "rows": rows,
        "axis": axis,
        "asynchronous": [
            now.get("axis_asynchronous_arcsec"),
            now.get("u_axis_asynchronous_arcsec"),
        ],
        "u_late_ns": now.get("u_late_ns"),
        "parity_counts": turns[-1].get("parity_counts"),
        "turn": now["turn"],
    }


def _axis_columns(drawn: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the radii of the axis' circles at each drawn turn, for every circle that occurs in
    some turn.

    A circle is the motion of one order and sense. A device that calibrates the mean of its heads
    sends the radii. For circles that three heads cannot separate from the disc's error the device
    sends 0.
    """
    columns = []
    for sense in ("forward", "backward"):
        radii = [turn.get(f"axis_{sense}_arcsec", []) for turn in drawn]
        for place in range(max(map(len, radii), default=0)):
            values = [row[place] if len(row) > place else None for row in radii]
            if any(values):
                columns.append({"name": f"{place + 1} a turn, {sense}", "arcsec": values})
    return columns


def _orbit_columns(orbit: AxisOrbit) -> dict[str, Any]:
    """Return the samples of the orbit (every second, third, … if there are many) and the mean orbit
    over all turns."""
    every = -(-orbit.angle_rad.size // _MOST_SAMPLES)
    samples = {"x": orbit.x_arcsec, "y": orbit.y_arcsec}
    columns: dict[str, Any] = {"u": list(orbit.u_arcsec)}
    for name, values in samples.items():
        mean = error_motion(orbit.angle_rad, values).mean
        columns[name] = np.round(values[::every], _DECIMALS).tolist()
        closed = np.append(mean, mean[0])
        columns[f"mean_{name}"] = [
            None if np.isnan(value) else round(float(value), _DECIMALS) for value in closed
        ]
    return columns


def _comparison(
    drawn: list[dict[str, Any]], before: dict[str, Any], now: dict[str, Any]
) -> dict[str, Any]:
    """Return the changes of the orders from turn ``before`` to turn ``now``, and the most changed
    orders at the drawn turns."""
    return {
        "turn": before["turn"],
        "recorded": _utc(before["recorded_s"]),
        "changes": [asdict(change) for change in changes_since(before, now)],
        "temperatures": [
            {"name": name, "before": before[key], "now": now[key]}
            for name, key in (("die", "temperature_c"), ("table", "table_c"))
            if before.get(key) is not None and now.get(key) is not None
        ],
        "orders": _order_columns(drawn, before, now),
    }


def _order_columns(
    drawn: list[dict[str, Any]], before: dict[str, Any], now: dict[str, Any]
) -> list[dict[str, Any]]:
    """Return the change of each order and the change's standard uncertainty u at each drawn turn,
    for the orders that have changed most."""
    earlier = {row[0]: row for row in before.get("harmonics", [])}

    def in_units_of_u(row: list[float]) -> float:
        size, u = order_change(earlier[row[0]], row)
        return size / u if u > 0.0 else size

    known = [row for row in now.get("harmonics", []) if row[0] in earlier]
    chosen = sorted(known, key=in_units_of_u, reverse=True)[:_MOST_ORDERS]
    columns = []
    for order in sorted(row[0] for row in chosen):
        sizes: list[float | None] = []
        errors: list[float | None] = []
        for turn in drawn:
            row = next((row for row in turn.get("harmonics", []) if row[0] == order), None)
            size, u = (None, None) if row is None else order_change(earlier[order], row)
            sizes.append(size)
            errors.append(u)
        columns.append({"order": order, "change": sizes, "u": errors})
    return columns


def _utc(seconds: float, unit: str = "seconds") -> str:
    moment = datetime.fromtimestamp(seconds, UTC).replace(tzinfo=None)
    return moment.isoformat(sep=" ", timespec=unit)
