"""What the firmware's console told: a line of JSON a turn, and the answer to ``status``."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass

from arctrue.studies.demo.files import ConsoleLine

_COUNTERS = (
    *(f"head{head}_{what}" for head in (1, 2) for what in ("index_errors", "illegals")),
    *("head1_overspeeds", "head2_overspeeds", "overruns", "stuck_captures"),
)


@dataclass(frozen=True, slots=True)
class ToldHarmonic:
    """An order as the firmware found it."""

    order: int
    amplitude_arcsec: float
    phase_rad: float
    standard_uncertainty_arcsec: float
    applied: bool


@dataclass(frozen=True, slots=True)
class ToldTurn:
    """A line of telemetry of a turn that was not refused."""

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
    harmonics: tuple[ToldHarmonic, ...]


def told_turns(console: Iterable[ConsoleLine]) -> list[ToldTurn]:
    """The turns that the firmware worked on; refused ones and alarms between turns left out."""
    turns = []
    for line in console:
        if line.typed or not line.text.startswith("{"):
            continue
        told = json.loads(line.text)
        if told["result"] in ("refused", "alarm"):
            continue
        turns.append(
            ToldTurn(
                clock=line.clock,
                number=told["turn"],
                samples=told["samples"],
                result=told["result"],
                reason=told["reason"],
                separation_deg=told["separation_deg"],
                u_separation_arcsec=told["u_separation_arcsec"],
                noise_arcsec=told["noise_arcsec"],
                active_arcsec=told["active_arcsec"],
                candidate_arcsec=told["candidate_arcsec"],
                alarms=tuple(told["alarms"]),
                harmonics=tuple(
                    ToldHarmonic(order, amplitude, phase, uncertainty, bool(applied))
                    for order, amplitude, phase, uncertainty, applied in told["harmonics"]
                ),
            )
        )
    return turns


def console_faults(console: Iterable[ConsoleLine]) -> list[str]:
    """What the firmware saw go wrong: refusals, alarms, counters that are not 0 or not told."""
    found = []
    counted: dict[str, str] = {}
    for line in console:
        if line.typed:
            continue
        if line.text.startswith("{"):
            told = json.loads(line.text)
            found += [f"turn {told['turn']}: alarm {alarm}" for alarm in told["alarms"]]
            if told["result"] == "refused":
                found.append(f"turn {told['turn']}: refused, {told['reason']}")
            continue
        name, _, value = line.text.partition(" ")
        counted[name] = value
    for name in _COUNTERS:
        if counted.get(name) != "0":
            found.append(f"{name}: expected 0, the firmware told {counted.get(name, 'nothing')}")
    return found
