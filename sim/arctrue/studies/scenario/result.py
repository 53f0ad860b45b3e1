"""Defines the result of a scenario."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from arctrue.gateware.coefficients import Coefficients
from arctrue.instrument.turn_score import TurnScore
from arctrue.studies.scenario.scenario import Scenario


@dataclass(frozen=True, slots=True)
class ScenarioTurn:
    """Result of one turn of the table's travel."""

    number: int
    """Number of the turn, from 1."""
    temperature_c: float
    """Temperature in the middle of the turn."""
    uncorrected: TurnScore | None
    """Error of the incoming signal of head 1."""
    corrected: TurnScore | None
    """Error of the output."""
    reference: TurnScore | None
    """Error of the output that a reference with its own errors would measure, at the faces only."""
    telemetry: tuple[dict[str, Any], ...]
    """Telemetry of the firmware during the turn."""
    flags: tuple[str, ...]
    """Flags that were raised in the turn."""
    events: tuple[str, ...]
    """Descriptions of the events in the turn."""
    bank: Coefficients | None = None
    """Coefficients at the end of the turn; None before the first calibration. The JSON omits
    them."""

    def as_json(self) -> dict[str, Any]:
        """Return everything except the coefficients as plain values.

        Returns
        -------
        dict
            Number, temperature, errors, telemetry, flags and events.
        """

        def error(found: TurnScore | None) -> dict[str, Any] | None:
            return None if found is None else found.as_json()

        return {
            "turn": self.number,
            "temperature_c": self.temperature_c,
            "uncorrected": error(self.uncorrected),
            "corrected": error(self.corrected),
            "reference": error(self.reference),
            "telemetry": list(self.telemetry),
            "flags": list(self.flags),
            "events": list(self.events),
        }


@dataclass(frozen=True, slots=True)
class ScenarioResult:
    """Result of a run: all turns, and the limits that the run exceeded."""

    scenario: Scenario
    """Scenario that was run."""
    turns: tuple[ScenarioTurn, ...]
    """Turns in the order of the motion."""
    illegal: int
    """Number of clocks in which both A and B of the output changed."""
    clocks: int
    """Number of simulated clocks of the gateware."""
    wall_s: float
    """Duration of the run on this computer, seconds."""
    broken: tuple[str, ...] = ()
    """Sentences about the limits that the run exceeded."""

    @property
    def applied(self) -> int:
        """Return the number of calibrations that the firmware applied."""
        return self._count("applied")

    @property
    def refused(self) -> int:
        """Return the number of captures that the firmware refused."""
        return self._count("refused")

    def _count(self, result: str) -> int:
        return sum(reply["result"] == result for turn in self.turns for reply in turn.telemetry)

    def as_json(self) -> dict[str, Any]:
        """Return the whole result as plain values.

        Returns
        -------
        dict
            Scenario, turns, and the exceeded limits.
        """
        return {
            "title": self.scenario.title,
            "counts_per_rev": self.scenario.scale.counts_per_rev,
            "lanes": self.scenario.scale.lanes,
            "clock_hz": self.scenario.clock_hz,
            "turns": [turn.as_json() for turn in self.turns],
            "applied": self.applied,
            "refused": self.refused,
            "illegal": self.illegal,
            "clocks": self.clocks,
            "wall_s": self.wall_s,
            "broken": list(self.broken),
        }
