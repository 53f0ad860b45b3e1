"""Compares all answers of a benchmark with truth and oracle, and computes rates with intervals, in
total and by world."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from arctrue.studies.benchmark.digests import set_name
from arctrue.studies.benchmark.independent.world import independent_worlds
from arctrue.studies.benchmark.intervals import (
    Rate,
    calibration_error,
    log_score_gain,
    rate,
    reliability,
)
from arctrue.studies.benchmark.outcome import (
    BAD_DATA,
    ERROR,
    FALSE_ADEQUATE,
    FIRST,
    GOOD,
    IN_CLASS,
    OSCILLATION,
    RIGHT,
    SILENT,
    UNKNOWN,
    Judged,
    sight,
)
from arctrue.studies.benchmark.worlds import WORLDS

SURE = 0.8
"""Probability above which an answer counts as sure."""
KINDS = ("name", "unknown", "none")
"""Kinds of answer to which a subject can give a probability."""
SIMULATED, INDEPENDENT = "simulated", "independent"
"""Names of the two generators: the simulated table, and the package ``independent``."""

FALSE = "false name or falsely adequate"

SIZE_EDGES = (0.0, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0, float("inf"))
"""Edges of the bins for the sizes of causes, in units of the oracle's detection limit."""


@dataclass(frozen=True, slots=True)
class Score:
    """Definition of a rate: it tells which sets count, which of these are hits, and which goal
    applies."""

    name: str
    counts: Callable[[Judged], bool]
    hits: Callable[[Judged], bool]
    at_most: float | None = None
    at_least: float | None = None
    world_at_most: float | None = None
    """Limit for a single world, which is looser than ``at_most``; None: ``at_most`` applies."""
    white_at_least: float | None = None
    """Limit for the world of white noise, which is stricter than ``at_least``; None: ``at_least``
    applies."""

    def of(self, sets: Iterable[Judged]) -> Rate:
        """Compute the rate over the sets that count."""
        return rate([self.hits(item) for item in sets if self.counts(item)])


def _any(_: Judged) -> bool:
    return True


def _visible(item: Judged) -> bool:
    return bool(item.seen())


def _catalogue(item: Judged) -> bool:
    return bool(item.seen("catalogue")) and not item.has_stranger and not item.left_open


def _stranger(item: Judged) -> bool:
    """Tell whether the oracle detects a cause of the kind ``stranger`` and none of the catalogue;
    return False if the design permits the answer's verdict and the verdict is not ``unknown``."""
    alone = bool(item.seen("stranger")) and not item.seen("catalogue")
    return alone and (item.answer["verdict"] == "unknown" or not item.left_open)


def _nothing(item: Judged) -> bool:
    return not item.truth["effects"]


def _of_several_lines(item: Judged) -> bool:
    """Tell whether the answer correctly names a line (a sine in angle or time) in a set with two or
    more lines that the oracle detects.
    """
    lines = [effect for effect in item.seen() if effect.get("values")]
    return item.outcome == RIGHT and len(lines) > 1 and bool(item.lines_named())


def _named_largest_line(item: Judged) -> bool:
    """Tell whether the named line is the largest, or larger than NEARLY_AS_LARGE times the
    largest."""
    largest = max(float(effect["rms_arcsec"]) for effect in item.seen() if effect.get("values"))
    named = max(float(effect["rms_arcsec"]) for effect in item.lines_named() or [])
    return named > NEARLY_AS_LARGE * largest


NEARLY_AS_LARGE = 0.8
"""Ratio of a line's size to the largest line's size, above which the answer may name the smaller
line first."""

SCORES = (
    Score("false name", _any, lambda item: item.falsely_named, at_most=0.01),
    Score(
        "falsely adequate, of what the oracle sees",
        _visible,
        lambda item: item.outcome == FALSE_ADEQUATE,
        at_most=0.01,
    ),
    Score(
        FALSE,
        _any,
        lambda item: item.falsely_named or item.outcome == FALSE_ADEQUATE,
        at_most=0.01,
        world_at_most=0.02,
    ),
    Score("false name where nothing is", _nothing, lambda item: item.falsely_named),
    Score(
        "neither adequate nor cannot tell where nothing is",
        _nothing,
        lambda item: item.outcome not in GOOD,
    ),
    Score(
        "right first, of what the oracle sees of the catalogue",
        _catalogue,
        lambda item: item.outcome in (RIGHT, FIRST),
        at_least=0.9,
        white_at_least=0.97,
    ),
    Score("named, of the same", _catalogue, lambda item: item.outcome == RIGHT),
    Score(
        "named or in the class, of the same",
        _catalogue,
        lambda item: item.outcome in (RIGHT, FIRST, IN_CLASS),
    ),
    Score(
        "silent where the oracle sees (cannot tell, bad data, error)",
        _visible,
        lambda item: item.outcome in (SILENT, BAD_DATA, ERROR),
    ),
    Score(
        "unknown, of visible strangers",
        _stranger,
        lambda item: item.answer["verdict"] == "unknown",
        at_least=0.9,
    ),
    Score(
        "unknown with its frequency, of visible damped oscillations",
        lambda item: bool(item.seen(OSCILLATION)) and not item.seen("catalogue"),
        lambda item: item.outcome == UNKNOWN and item.states_oscillation,
        at_least=0.9,
    ),
    Score(
        "unknown, of visible products of parts",
        lambda item: bool(item.seen("parts")) and not item.seen("catalogue"),
        lambda item: item.answer["verdict"] == "unknown",
        at_least=0.9,
    ),
    Score(
        "unknown with the right parts, of the same",
        lambda item: bool(item.seen("parts")) and not item.seen("catalogue"),
        lambda item: any(
            set(effect["parts"]) == set(item.answer.get("parts") or [])
            for effect in item.seen("parts")
        ),
    ),
    Score(
        "the largest line, of right names of one of several",
        _of_several_lines,
        _named_largest_line,
    ),
    Score(
        "a second name that is not there, of right names",
        lambda item: item.outcome == RIGHT,
        lambda item: item.second_name is not None,
        at_most=0.01,
    ),
)
"""Definitions of all rates with their goals."""


def scored(sets: Sequence[Judged]) -> dict[str, Any]:
    """Return rates, probabilities, sizes, confusion and failures as a mapping for JSON."""
    worlds = [
        name for name in (*WORLDS, *independent_worlds()) if any(i.world == name for i in sets)
    ]
    generators = by_generator(sets)
    groups = {
        "all": sets,
        **(generators if len(generators) > 1 else {}),
        **{world: [item for item in sets if item.world == world] for world in worlds},
    }
    rates = {
        score.name: {name: score.of(group).data() for name, group in groups.items()}
        for score in SCORES
    }
    return {
        "sets": len(sets),
        "visible": sum(_visible(item) for item in sets),
        "rates": rates,
        "generators": list(generators),
        "failed_worlds": [world for world in worlds if _fails(world, sets)],
        "probability": probabilities(sets),
        "probability_by_generator": {
            name: probabilities(group) for name, group in generators.items()
        },
        "held_out_over_floor": held_out(sets),
        "found_by_size_in_limits": sizes(sets),
        "found_by_effect": by_effect(sets),
        "outcomes": {
            world: dict(Counter(item.outcome for item in sets if item.world == world))
            for world in worlds
        },
        "confusion": confusion(sets),
        "failures": [failure(item) for item in sets if is_failure(item)],
    }


def _fails(world: str, sets: Sequence[Judged]) -> bool:
    """Tell whether the lower end of the interval of a world's false rate exceeds the goal."""
    (false,) = (score for score in SCORES if score.name == FALSE)
    most, _ = goal_of(false, world)
    assert most is not None
    return false.of([item for item in sets if item.world == world]).interval[0] > most


def by_generator(sets: Sequence[Judged]) -> dict[str, list[Judged]]:
    """Group the sets by generator; the first generator comes first."""
    found: dict[str, list[Judged]] = {}
    for name, second in ((SIMULATED, False), (INDEPENDENT, True)):
        made = [item for item in sets if (item.world in independent_worlds()) == second]
        if made:
            found[name] = made
    return found


def goal_of(score: Score, world: str) -> tuple[float | None, float | None]:
    """Return a score's upper and lower limit for one world, or for ``all`` worlds together."""
    most, least = score.at_most, score.at_least
    if world != "all" and score.world_at_most is not None:
        most = score.world_at_most
    if world == "white" and score.white_at_least is not None:
        least = score.white_at_least
    return most, least


def probabilities(sets: Sequence[Judged]) -> dict[str, Any] | None:
    """Return the mean probability of the truth, and the calibration; None if no answer states
    probabilities."""
    stated = [item.first_probability() for item in sets]
    pairs = [pair for pair in stated if pair is not None]
    if not pairs:
        return None
    given, right = [pair[0] for pair in pairs], [pair[1] for pair in pairs]
    bins = reliability(given, right)
    error = calibration_error(given, right)
    return {
        "mean_of_truth_where_visible": _mean_of_truth(filter(_visible, sets)),
        "mean_of_truth_of_catalogue": _mean_of_truth(filter(_catalogue, sets)),
        "calibration_error": error.data(),
        "log_score_gain": log_score_gain(given, right).data(),
        "reliability": [
            {"mean_probability": item.mean_probability, **item.right.data()} for item in bins
        ],
        "right_of": {kind: _right_of(sets, kind).data() for kind in KINDS},
        "wrong_where_sure": {kind: _wrong_where_sure(sets, kind).data() for kind in KINDS},
    }


def _right_of(sets: Sequence[Judged], kind: str) -> Rate:
    """Return the rate of right answers among the answers that give ``kind`` the largest
    probability."""
    stated = [item.first_probability() for item in sets if item.first_kind() == kind]
    return rate([pair[1] for pair in stated if pair is not None])


def _wrong_where_sure(sets: Sequence[Judged], kind: str) -> Rate:
    """Return the rate of wrong answers among the answers that give ``kind`` a probability above
    SURE."""
    stated = [item.first_probability() for item in sets if item.first_kind() == kind]
    return rate([not pair[1] for pair in stated if pair is not None and pair[0] > SURE])


def _mean_of_truth(sets: Iterable[Judged]) -> float | None:
    given = [value for item in sets if (value := item.probability_of_truth()) is not None]
    return float(np.mean(given)) if given else None


def held_out(sets: Sequence[Judged]) -> dict[str, float] | None:
    """Return quantiles of the held-out error divided by the noise floor, over the good answers
    ``named`` and ``adequate`` in sets with at most one cause."""
    ratios = [
        ratio
        for item in sets
        if item.outcome in GOOD
        and len(item.hidden) <= 1
        and item.answer["verdict"] in ("named", "adequate")
        and (ratio := item.held_out_over_floor()) is not None
    ]
    if not ratios:
        return None
    found = np.quantile(ratios, [0.5, 0.95, 1.0])
    return {"median": float(found[0]), "95 %": float(found[1]), "largest": float(found[2])}


def sizes(sets: Sequence[Judged]) -> list[dict[str, Any]]:
    """Return how many causes of the catalogue are named first in sets with one cause, by size in
    units of the oracle's detection limit."""
    found = []
    single = [
        (sight(item.truth["effects"][0]).size_in_limits, item.outcome in (RIGHT, FIRST))
        for item in sets
        if len(item.truth["effects"]) == 1 and not item.has_stranger
    ]
    for low, high in pairwise(SIZE_EDGES):
        hits = rate([hit for size, hit in single if low <= size < high])
        found.append({"from": low, "to": None if np.isinf(high) else high, **hits.data()})
    return found


def by_effect(sets: Sequence[Judged]) -> dict[str, dict[str, Any]]:
    """Return, for each name, the size of the smallest cause that was found and of the largest cause
    that was missed.

    Only sets with a single cause of the catalogue count. Sizes are in units of the oracle's
    detection limit; None if there is no such cause.
    """
    sizes_of: dict[str, list[tuple[float, bool]]] = {}
    for item in sets:
        if len(item.truth["effects"]) == 1 and not item.has_stranger:
            size = sight(item.truth["effects"][0]).size_in_limits
            sizes_of.setdefault(item.hidden[0], []).append((size, item.outcome in (RIGHT, FIRST)))
    return {
        name: {
            "smallest_put_first": min((size for size, hit in of if hit), default=None),
            "largest_not_put_first": max((size for size, hit in of if not hit), default=None),
            **rate([hit for _, hit in of]).data(),
        }
        for name, of in sorted(sizes_of.items())
    }


def confusion(sets: Sequence[Judged]) -> dict[str, dict[str, int]]:
    """Count each answer, grouped by the hidden content (nothing, one cause, or ``several``)."""
    found: dict[str, Counter[str]] = {}
    for item in sets:
        truth = item.label if len(item.hidden) <= 1 else "several"
        said = item.said
        if truth == "several" and item.outcome in (RIGHT, FIRST):
            said = "one of them"
        elif item.answer["verdict"] == "ambiguous":
            said = f"ambiguous ({item.outcome})"
        found.setdefault(truth, Counter())[said] += 1
    return {truth: dict(found[truth].most_common()) for truth in sorted(found)}


def is_failure(item: Judged) -> bool:
    """Tell whether the outcome is not good, or a further name of the answer is wrong."""
    return item.outcome not in GOOD or item.second_name is not None


def failure(item: Judged) -> dict[str, Any]:
    """Return a failed set as a mapping for JSON, with the command that makes the set again."""
    return {
        "set": set_name(item.task),
        "world": item.world,
        "bad": list(item.truth["adverse_conditions"]),
        "hidden": [
            f"{effect['effect']} {effect['size']:.3g} {effect['unit']}, "
            f"{sight(effect).size_in_limits:.3g} limits"
            for effect in item.truth["effects"]
        ],
        "outcome": item.outcome,
        "said": item.said,
        "second_name": item.second_name,
        "error": item.answer.get("error"),
        "command": item.command(),
    }


def judged(results: Iterable[tuple[Mapping[str, Any], Mapping[str, Any]]]) -> list[Judged]:
    """Return the tasks and their results as judged sets."""
    return [Judged(task, result["truth"], result["answer"]) for task, result in results]
