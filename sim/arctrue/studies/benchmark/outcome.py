"""Compares one answer with the truth of its set and classifies the outcome."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from arctrue.base.units import arcsec_per_count
from arctrue.studies.benchmark.oracle import Sight, visible

NEAR_LINE = 1.5
"""Largest permitted distance of the order or frequency that the answer states from the true one, in
units of the resolution.
"""
OSCILLATION = "oscillation"
"""Kind of a hidden damped oscillation that noise drives; no name of the catalogue is a right answer
for it."""
STATED = {"order": "order", "hz": "frequency"}
"""Name of the answer's parameter with a line's order or frequency, by the key of this value in the
truth."""
MATTERS_COUNTS = 0.5
COUNT_ARCSEC = arcsec_per_count(1 << 24)
MATTERS_ARCSEC = MATTERS_COUNTS * COUNT_ARCSEC

RIGHT = "right"
FIRST = "first in class"
IN_CLASS = "in class"
UNKNOWN = "unknown, rightly"
ADEQUATE = "adequate, rightly"
QUIET = "cannot tell, rightly"
OPEN = "left open, rightly"
FALSE_NAME = "false name"
FALSE_CLASS = "class without it"
FALSE_UNKNOWN = "unknown, wrongly"
FALSE_ADEQUATE = "falsely adequate"
SILENT = "silent"
BAD_DATA = "bad data"
ERROR = "error"
OUTCOMES = (
    RIGHT,
    FIRST,
    IN_CLASS,
    UNKNOWN,
    ADEQUATE,
    QUIET,
    OPEN,
    FALSE_NAME,
    FALSE_CLASS,
    FALSE_UNKNOWN,
    FALSE_ADEQUATE,
    SILENT,
    BAD_DATA,
    ERROR,
)
GOOD = (RIGHT, FIRST, UNKNOWN, ADEQUATE, QUIET, OPEN)
"""Outcomes that count as good. ``in class`` is not good, because another name than the true one
came first in the answer."""


@dataclass(frozen=True, slots=True)
class Judged:
    """Scored set: its task, its truth, the answer, and the outcome."""

    task: Mapping[str, Any]
    truth: Mapping[str, Any]
    answer: Mapping[str, Any]

    @property
    def world(self) -> str:
        """Return the name of the world from which the set was drawn."""
        return str(self.task["world"])

    @property
    def hidden(self) -> list[str]:
        """Return the names of the hidden causes."""
        return [str(item["effect"]) for item in self.truth["effects"]]

    @property
    def accepted(self) -> Mapping[str, Sequence[str]]:
        """Return the further answers that the truth accepts as right or as not false: ``names``,
        ``alike``, ``verdicts``.

        A set of the simulated table (the first generator) has no further answers.
        """
        found: Mapping[str, Sequence[str]] = self.truth.get("accepted", {})
        return found

    @property
    def left_open(self) -> bool:
        """Tell whether the design of the set permits the answer's verdict, independent of the
        oracle's result."""
        return self.answer["verdict"] in self.accepted.get("verdicts", ())

    @property
    def right_names(self) -> list[str]:
        """Return the names of the hidden causes, and other names of the same causes."""
        return [*self.hidden, *self.accepted.get("names", ())]

    def lines_named(self) -> list[Mapping[str, Any]] | None:
        """Return the hidden causes whose order or frequency agrees with the order or frequency of
        the named line.

        Returns None if the answer states no order or frequency, or if no hidden cause has one.
        """
        stated = self.answer.get("parameters") or {}
        comparable, found = False, []
        for effect in self.truth["effects"]:
            for key, places in (effect.get("values") or {}).items():
                if STATED[key] not in stated:
                    continue
                comparable = True
                width = NEAR_LINE * float(self.truth["resolution"][key])
                if any(abs(float(stated[STATED[key]]) - place) <= width for place in places):
                    found.append(effect)
        return found if comparable else None

    @property
    def states_oscillation(self) -> bool:
        """Tell whether the answer states a damped oscillation at the frequency of a hidden
        oscillation.

        The stated frequency may differ by the half width at half power, γ/(2π). Maximum likelihood
        over a record of length T has the standard uncertainty √(γ/T)/(2π) (Gersch, IEEE Trans.
        Autom. Control 19 (1974) 558), which is at most a quarter of the half width, because T·γ is
        20 or more.
        """
        stated = self.answer.get("oscillation_hz")
        places = [
            item["oscillation"] for item in self.truth["effects"] if item["kind"] == OSCILLATION
        ]
        return stated is not None and any(
            abs(float(stated) - place["hz"]) <= place["half_width_hz"] for place in places
        )

    @property
    def label(self) -> str:
        """Return the names of the hidden causes in one text, or ``nothing``."""
        return " + ".join(self.hidden) or "nothing"

    def seen(self, *kinds: str) -> list[Mapping[str, Any]]:
        """Return the causes of these kinds (default: all) that the oracle detects and that are
        large enough to matter."""
        return [
            item
            for item in self.truth["effects"]
            if (not kinds or item["kind"] in kinds) and visible([sight(item)], MATTERS_ARCSEC)
        ]

    @property
    def has_stranger(self) -> bool:
        """Tell whether the set contains a cause that is not in the catalogue."""
        return any(item["kind"] != "catalogue" for item in self.truth["effects"])

    @property
    def said(self) -> str:
        """Return the name that the answer states, or its verdict if it states no name."""
        verdict, effects = self.answer["verdict"], self.answer.get("class") or []
        if verdict == "named":
            return str(self.answer.get("named"))
        if verdict == "ambiguous":
            return f"ambiguous: {', '.join(effects)}"
        return str(verdict)

    @property
    def outcome(self) -> str:
        """Return the outcome, one of OUTCOMES."""
        verdict = self.answer["verdict"]
        allowed = self.left_open
        if verdict == "named":
            return self._named(self.answer.get("named"))
        if verdict == "ambiguous":
            return self._class(list(self.answer.get("class") or []), allowed)
        if verdict == "unknown":
            return self._unknown(allowed)
        if verdict == "adequate":
            return FALSE_ADEQUATE if self.seen() else ADEQUATE
        if verdict == "cannot_tell":
            return SILENT if self.seen() and not allowed else QUIET
        return BAD_DATA if verdict == "bad_data" else ERROR

    def _unknown(self, allowed: bool) -> str:
        """Score the verdict ``unknown``; it is right for a cause outside the catalogue, or for a
        hidden oscillation whose frequency the answer states."""
        kinds = {item["kind"] for item in self.truth["effects"]}
        right = bool(kinds - {"catalogue", OSCILLATION}) or self.states_oscillation
        return UNKNOWN if right or (allowed and self.hidden) else FALSE_UNKNOWN

    def _named(self, named: str | None) -> str:
        """Score a named effect; the order or frequency of a sine must agree with that of a hidden
        sine.
        """
        elsewhere = self.lines_named() == []
        if named in self.right_names:
            return FALSE_NAME if elsewhere else RIGHT
        return IN_CLASS if named in self.accepted.get("alike", ()) and not elsewhere else FALSE_NAME

    def _class(self, effects: list[str], allowed: bool) -> str:
        if effects and effects[0] in self.right_names:
            return FIRST
        if allowed and self.hidden:
            return OPEN
        some = {*self.right_names, *self.accepted.get("alike", ())}
        return IN_CLASS if set(effects) & some else FALSE_CLASS

    @property
    def falsely_named(self) -> bool:
        """Tell whether the answer gives a wrong name.

        A false class of names counts as a wrong name if no hidden cause of the set has a name, that
        is, if there is none or only a damped oscillation.
        """
        outcome = self.outcome
        causes = any(item["kind"] != OSCILLATION for item in self.truth["effects"])
        return outcome == FALSE_NAME or (outcome == FALSE_CLASS and not causes)

    @property
    def second_name(self) -> str | None:
        """Return the first further name of the answer that is not right; None if there is no such
        name."""
        if self.answer["verdict"] != "named":
            return None
        return next(
            (name for name in self.answer.get("further") or [] if name not in self.right_names),
            None,
        )

    def probability_of_truth(self) -> float | None:
        """Return the probability that the answer gives to the truth; the probabilities of several
        hidden causes are added.

        Returns None if the answer states no probability.
        """
        stated = self.answer.get("probability")
        if stated is None:
            return None
        truth = {_stated_as(item) for item in self.seen()}
        if truth:
            truth |= self._also()
        return min(1.0, sum(float(stated.get(name, 0.0)) for name in truth or {"none"}))

    def _also(self) -> set[str]:
        """Return the keys of the stated probabilities that count as right, in addition to the
        hidden causes."""
        known = "unknown" in self.accepted.get("verdicts", ())
        return {*self.accepted.get("names", ()), *(["unknown"] if known else [])}

    def first_probability(self) -> tuple[float, bool] | None:
        """Return the largest stated probability, and whether its key is the truth."""
        stated = self.answer.get("probability")
        if not stated:
            return None
        name = max(stated, key=lambda key: float(stated[key]))
        truth = {_stated_as(item) for item in self.truth["effects"]}
        if truth:
            truth |= self._also()
        right = name in truth or (name == "none" and not self.seen())
        return float(stated[name]), right

    def first_kind(self) -> str | None:
        """Return the kind of answer that has the largest stated probability: ``name``, ``unknown``
        or ``none``."""
        stated = self.answer.get("probability")
        if not stated:
            return None
        name = max(stated, key=lambda key: float(stated[key]))
        return name if name in ("unknown", "none") else "name"

    def held_out_over_floor(self) -> float | None:
        """Return the held-out error divided by the RMS of the simulated noise, in the channel where
        this ratio is largest."""
        floor, found = self.truth["floor_arcsec"], self.answer.get("held_out_arcsec") or {}
        ratios = [float(found[name]) / float(floor[name]) for name in found if floor.get(name)]
        return max(ratios) if ratios else None

    def command(self) -> str:
        """Return the command line that makes this set again."""
        task = self.task
        return (
            f"arctrue benchmark set FOLDER --world {task['world']} --content {task['content']} "
            f"--seed {task['seed']} --samples {task['samples']}"
        )


def _stated_as(effect: Mapping[str, Any]) -> str:
    """Return the key under which the stated probabilities contain a cause."""
    return str(effect["effect"]) if effect["kind"] == "catalogue" else "unknown"


def sight(effect: Mapping[str, Any]) -> Sight:
    """Return the oracle's result for a cause of the truth."""
    return Sight(effect["noncentrality"], effect["needed"], effect["rms_arcsec"])
