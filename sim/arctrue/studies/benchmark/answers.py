"""Whose answers are scored: those of a run, or anybody's from a file."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from arctrue.studies.benchmark.outcome import Judged
from arctrue.studies.benchmark.plan import TIERS, read_plan
from arctrue.studies.benchmark.score import judged, scored
from arctrue.studies.campaign import Task, read_results
from arctrue.studies.campaign.task import digest

VERDICTS = ("adequate", "named", "ambiguous", "unknown", "cannot_tell", "bad_data", "error")


class AnswersError(ValueError):
    """A file of answers that cannot be read."""


def set_name(task: Task) -> str:
    """The name of a set's folder: it tells nothing of what is in it."""
    return digest({name: value for name, value in task.items() if name != "subject"})[:12]


def score_folders(folders: Sequence[Path], subject: str, answers: Path | None) -> dict[str, Any]:
    """The score of one subject's results; with ``answers``, of those in the file in their place.

    Raises PlanError where the sets of a drawn seed are scored by another state of the scoring, and
    AnswersError for a file of answers that is not as it should be.
    """
    plan = read_plan(folders[0])
    if TIERS[plan.tier].seed is None:
        plan.check()
    results = read_results([folder / subject for folder in folders])
    sets = judged((item.task, item.result) for item in results)
    if answers is not None:
        sets = _answered(sets, answers)
    order = {json.dumps(task, sort_keys=True): at for at, task in enumerate(plan.tasks(subject))}
    sets.sort(key=lambda item: order.get(json.dumps(item.task, sort_keys=True), len(order)))
    return scored(sets)


def _answered(sets: Sequence[Judged], path: Path) -> list[Judged]:
    try:
        given: Mapping[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise AnswersError(f"{path}: no JSON: {error}") from None
    names = {set_name(item.task): item for item in sets}
    if not isinstance(given, dict):
        raise AnswersError(f"{path}: expected an object with one answer a set")
    strange = sorted(set(given) - set(names))
    if strange:
        raise AnswersError(f"{path}: no set is called {strange[0]!r}")
    missing = sorted(set(names) - set(given))
    if missing:
        raise AnswersError(f"{path}: {len(missing)} sets have no answer, the first is {missing[0]}")
    for name, answer in given.items():
        if not isinstance(answer, dict) or answer.get("verdict") not in VERDICTS:
            raise AnswersError(
                f"{path}: {name}.verdict: expected one of {', '.join(VERDICTS)}, found "
                f"{answer.get('verdict') if isinstance(answer, dict) else answer!r}"
            )
    return [Judged(item.task, item.truth, given[name]) for name, item in names.items()]
