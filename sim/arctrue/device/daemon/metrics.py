"""Formats the state of a daemon and the latest turn as metrics in Prometheus' text format, version
0.0.4."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from arctrue.device.daemon.state import DaemonState

CONTENT_TYPE = "text/plain; version=0.0.4; charset=utf-8"
_COUNTERS = {
    "turns": "Lines of telemetry since the start of the daemon.",
    "damaged_lines": "Lines of telemetry that could not be read.",
    "too_long_lines": "Lines dropped because of their length.",
    "unrecorded_turns": "Turns that could not be written to the record.",
    "reconnections": "Times that the serial port was opened again.",
    "dropped_clients": "Clients dropped because they did not read.",
    "captures": "Captures taken.",
    "failed_captures": "Captures that could not be taken.",
    "probe_edges": "Edges at probe_in and pulses of compare_out that the daemon has received.",
    "probe_missed": "Edges at probe_in and pulses of compare_out that the daemon has missed.",
}
_GAUGES = {
    "connected": "1 if the serial port is open.",
    "recording": "1 if turns are written to the record.",
    "watchers": "Programs that watch.",
    "console_in_use": "1 if an operator has the console.",
}
_OF_TURN = {
    "time_s": ("device_time_seconds", "Time of the device's clock at the latest turn."),
    "separation_deg": ("head_separation_degrees", "Angle between the heads."),
    "noise_arcsec": ("noise_arcsec", "Noise of a reading, standard deviation."),
    "residual_arcsec": ("residual_arcsec", "Residual of the estimate, RMS."),
    "active_arcsec": ("error_active_arcsec", "Remaining error with the active set, RMS."),
    "loaded_arcsec": ("error_loaded_arcsec", "Residual of the loaded orders, RMS."),
    "temperature_c": ("die_temperature_celsius", "Temperature of the die."),
    "table_c": ("table_temperature_celsius", "Temperature of the table."),
}
_OF_ORDER = {
    1: ("order_amplitude_arcsec", "Amplitude of an order of the angle error."),
    2: ("order_phase_radians", "Phase of an order: amplitude · cos(order · angle + phase)."),
    3: ("order_u_arcsec", "Standard uncertainty of an order's cosine and sine."),
    4: ("order_applied", "1 if the order is corrected."),
}


def metrics_text(state: DaemonState) -> str:
    """Return all metrics with the label ``port``; values that the device did not send are
    omitted."""
    port = {"port": state.port}
    values = state.as_dict()
    lines: list[str] = []
    for name, text in _COUNTERS.items():
        lines += _family(f"{name}_total", "counter", text, [(port, float(values[name]))])
    for name, text in _GAUGES.items():
        lines += _family(name, "gauge", text, [(port, float(values[name]))])
    lines += _family(
        "alarm",
        "gauge",
        "1 for each alarm at present.",
        [({**port, "alarm": a}, 1.0) for a in state.alarms],
    )
    lines += _family(
        "machine_alarm",
        "gauge",
        "1 for each parameter whose limit arctrue life reports as passed or near.",
        [({**port, "alarm": name}, 1.0) for name in state.machine_alarms],
    )
    latest = state.latest
    if latest is not None:
        lines += _of_turn(latest, port)
    return "\n".join(lines) + "\n"


def _of_turn(latest: dict[str, Any], port: dict[str, str]) -> Iterable[str]:
    text = "Time at which the latest turn arrived, seconds since 1970."
    yield from _family("turn_recorded_seconds", "gauge", text, [(port, latest["recorded_s"])])
    for field, (name, text) in _OF_TURN.items():
        value = latest.get(field)
        if value is not None:
            yield from _family(name, "gauge", text, [(port, float(value))])
    for place, (name, text) in _OF_ORDER.items():
        rows = [
            ({**port, "order": str(h[0])}, float(h[place])) for h in latest.get("harmonics", [])
        ]
        yield from _family(name, "gauge", text, rows)


def _family(
    name: str, kind: str, text: str, samples: list[tuple[dict[str, str], float]]
) -> list[str]:
    name = f"arctrue_{name}"
    lines = [f"# HELP {name} {text}", f"# TYPE {name} {kind}"]
    for labels, value in samples:
        marks = ",".join(f'{key}="{_escaped(label)}"' for key, label in labels.items())
        shown = repr(value) if math.isfinite(value) else "NaN"
        lines.append(f"{name}{{{marks}}} {shown}")
    return lines


def _escaped(label: str) -> str:
    return label.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n")
