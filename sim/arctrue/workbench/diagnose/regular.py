"""Regular causes that a forward search finds in a dense reference: lines, by the error they take.

Rows that are left out and predicted from their neighbours cannot show a line far above their
scatter; the search predicts whole blocks of the record, and its lines have passed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from arctrue.workbench.effects.base import Effect, Nonlinear
from arctrue.workbench.inference.forward.of_solution import records_of
from arctrue.workbench.inference.forward.record import Record
from arctrue.workbench.inference.forward.search import Line, LineSearch, search_lines
from arctrue.workbench.inference.forward.tests_of_a_line import nearest
from arctrue.workbench.inference.solution import Solution

SAME_LINE = 1.5
"""Of 1/span: a line over the angle is so wide over time, at about one speed."""


@dataclass(frozen=True, eq=False)
class RegularCause:
    """Lines that one cause makes: one line, or several multiples of what the set declares."""

    effect: Effect
    nonlinear: Nonlinear
    lines: tuple[Line, ...]
    """The largest first."""
    in_time: bool
    turns_s: float | None
    """Speed at which an order is a frequency; None where they differ."""

    @property
    def taken_arcsec(self) -> float:
        """RMS over all rows of what the other blocks' prediction takes away."""
        return float(np.sqrt(sum(line.taken_arcsec**2 for line in self.lines)))

    @property
    def trials(self) -> float:
        """Places that its p pays for."""
        return float(len(self.lines)) if self.lines[0].multiple else self.lines[0].independent

    def period_s(self, line: Line) -> float | None:
        """Of one of its lines, where it is known."""
        if self.in_time:
            return 1.0 / line.rate
        return None if self.turns_s is None else 1.0 / (line.rate * self.turns_s)

    def data(self) -> dict[str, Any]:
        """As JSON."""
        return {
            "effect": self.effect.name,
            "taken_arcsec": self.taken_arcsec,
            "lines": [
                {
                    "order": None if self.in_time else line.rate,
                    "frequency_hz": line.rate if self.in_time else None,
                    "period_s": self.period_s(line),
                    "multiple": line.multiple,
                    "amplitude_arcsec": line.amplitude_arcsec,
                    "taken_arcsec": line.taken_arcsec,
                    "share_predicted": line.share,
                    "periods": line.periods,
                }
                for line in self.lines
            ],
        }

    def words(self) -> str:
        """Its name, what it takes away and its lines, the largest first."""
        lines = ", ".join(
            f"{line.amplitude_arcsec:.2g}″ at {self._where(line)}" for line in self.lines
        )
        return f"{self.effect.name} {self.taken_arcsec:.2g}″ RMS ({lines})"

    def _where(self, line: Line) -> str:
        period_s = self.period_s(line)
        seconds = None if period_s is None else f"{period_s:.4g} s"
        if self.in_time and seconds is not None:
            return seconds
        order = f"order {line.rate:.5g}"
        return order if seconds is None else f"{seconds}, {order}"


@dataclass(frozen=True, eq=False)
class Findings:
    """What a dense reference shows beside a model, whatever its verdict."""

    causes: tuple[RegularCause, ...] = ()
    """By the error that they take away, the largest first."""
    whiteness_p: float | None = None
    """Of Ljung and Box, with all lines in the model; None where nothing was searched."""

    def data(self) -> dict[str, Any]:
        """As JSON."""
        return {
            "regular": [cause.data() for cause in self.causes],
            "whiteness_p": self.whiteness_p,
        }

    def sentences(self) -> list[str]:
        """In words, a sentence each."""
        if not self.causes:
            return []
        words = "; ".join(cause.words() for cause in self.causes)
        return [f"Regular in the reference, by the error that goes with it: {words}."]


def findings_of(solution: Solution, effects: Mapping[str, type[Effect]]) -> Findings:
    """Search every record of a model's reference for regular lines."""
    expected = _expected(solution, effects)
    unknown = next((kind() for kind in effects.values() if kind.search_kind == "line"), None)
    if unknown is None:
        return Findings()
    declared = None
    if expected is not None:
        declared = expected.declared_order(solution.observations)
    causes: list[RegularCause] = []
    whiteness: list[float] = []
    rows = solution.observations.reference
    timed = rows is not None and rows.time_s is not None
    for record in records_of(solution, declared):
        found = search_lines(record)
        whiteness.append(found.whiteness_p)
        turns_s = record.turns_on_the_clock if timed else None
        causes += [
            item
            for item in _causes(found, expected, unknown, turns_s)
            if not any(_is_same(item, other, record) for other in causes)
        ]
    causes.sort(key=lambda item: -item.taken_arcsec)
    return Findings(tuple(causes), min(whiteness, default=None))


def _expected(solution: Solution, effects: Mapping[str, type[Effect]]) -> Effect | None:
    """An effect that the model lacks and whose order the set declares."""
    present = {term.effect.name for term in solution.terms}
    for name, kind in effects.items():
        if name not in present and kind.multiples_setting is not None:
            effect = kind()
            if effect.declared_order(solution.observations) is not None:
                return effect
    return None


def _causes(
    found: LineSearch, expected: Effect | None, unknown: Effect, timed_turns_s: float | None
) -> list[RegularCause]:
    record = found.record
    turns_s = None if record.in_time else timed_turns_s
    causes = [
        RegularCause(unknown, _place(line, record), (line,), record.in_time, turns_s)
        for line in found.lines
        if line.multiple is None
    ]
    of_declared = tuple(line for line in found.lines if line.multiple is not None)
    if of_declared and expected is not None and expected.multiples_setting is not None:
        multiples = sorted({line.multiple for line in of_declared if line.multiple is not None})
        form = type(expected)(**{expected.multiples_setting: multiples})
        causes.append(RegularCause(form, {}, of_declared, record.in_time, turns_s))
    return causes


def _is_same(item: RegularCause, other: RegularCause, record: Record) -> bool:
    """A line over time is one that was found over the angle."""
    if not item.in_time or other.in_time or other.turns_s is None:
        return False
    rates = [line.rate * other.turns_s for line in other.lines]
    return nearest(rates, item.lines[0].rate) * record.span < SAME_LINE


def _place(line: Line, record: Record) -> dict[str, float]:
    return {
        "order": 0.0 if record.in_time else line.rate,
        "frequency": line.rate if record.in_time else 0.0,
        "in_time": float(record.in_time),
        "in_capture": 0.0,
    }


def without(causes: Sequence[RegularCause], one: RegularCause | None) -> tuple[RegularCause, ...]:
    """What is left of some causes with one of them in the model."""
    return tuple(item for item in causes if item is not one)
