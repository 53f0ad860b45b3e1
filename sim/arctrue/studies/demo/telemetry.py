"""Parses the firmware's console: a line of JSON per turn, and the answer to ``status``."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Literal

from msgspec import Struct

from arctrue.base.typed_content import typed
from arctrue.studies.demo.files import ConsoleLine

_COUNTERS = (
    *(f"head{head}_{what}" for head in (1, 2) for what in ("index_errors", "illegals")),
    *("head1_overspeeds", "head2_overspeeds", "overruns", "stuck_captures"),
)


class ReportedHarmonic(Struct, frozen=True, array_like=True):
    """Order in the result that the firmware reports: its coefficients and their uncertainty."""

    order: int
    amplitude_arcsec: float
    phase_rad: float
    standard_uncertainty_arcsec: float
    applied: Literal[0, 1]


class ReportedTurn(Struct, frozen=True, rename={"number": "turn"}):
    """Line of telemetry that the firmware prints for an accepted turn."""

    clock: int
    number: int
    samples: int
    result: str
    reason: str
    separation_deg: float
    u_separation_arcsec: float
    noise_arcsec: float
    active_arcsec: float
    candidate_arcsec: float
    alarms: tuple[str, ...]
    harmonics: tuple[ReportedHarmonic, ...]


def telemetry_turns(console: Iterable[ConsoleLine]) -> list[ReportedTurn]:
    """Return the turns that the firmware calibrated; refused turns and alarms are left out."""
    sent = [
        {**json.loads(line.text), "clock": line.clock}
        for line in console
        if not line.typed and line.text.startswith("{")
    ]
    return [
        typed(turn, ReportedTurn) for turn in sent if turn["result"] not in ("refused", "alarm")
    ]


def console_faults(console: Iterable[ConsoleLine]) -> list[str]:
    """List faults in the console's lines: refusals, alarms, counters that are not reported as 0."""
    found = []
    counted: dict[str, str] = {}
    for line in console:
        if line.typed:
            continue
        if line.text.startswith("{"):
            sent = json.loads(line.text)
            found += [f"turn {sent['turn']}: alarm {alarm}" for alarm in sent["alarms"]]
            if sent["result"] == "refused":
                found.append(f"turn {sent['turn']}: refused, {sent['reason']}")
            continue
        name, _, value = line.text.partition(" ")
        counted[name] = value
    for name in _COUNTERS:
        if counted.get(name) != "0":
            found.append(
                f"{name}: expected 0, the firmware reported {counted.get(name, 'nothing')}"
            )
    return found
