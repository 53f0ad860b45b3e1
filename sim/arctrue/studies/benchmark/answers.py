"""Whose answers are scored: those of a run, or anybody's from a file."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from arctrue.measurement import write_measurement_set
from arctrue.studies.benchmark.outcome import Judged
from arctrue.studies.benchmark.plan import TIERS, Plan, read_plan
from arctrue.studies.benchmark.score import judged, scored
from arctrue.studies.benchmark.sets import make_set
from arctrue.studies.benchmark.subject import SUBJECTS
from arctrue.studies.campaign import Task, read_results
from arctrue.studies.campaign.store import HEADER
from arctrue.studies.campaign.task import digest
from arctrue.studies.simulate.truth import fingerprint

VERDICTS = ("adequate", "named", "ambiguous", "unknown", "cannot_tell", "bad_data", "error")


class AnswersError(ValueError):
    """A file of answers that cannot be read."""


def set_name(task: Task) -> str:
    """The name of a set's folder: it tells nothing of what is in it."""
    return digest({name: value for name, value in task.items() if name != "subject"})[:12]


def write_sets(plan: Plan, out: Path, first: int | None, say: Callable[[str], None]) -> str:
    """Write the sets of a plan into folders of their names; the digest of all their files.

    The digest is the same on every machine whose sines and cosines are: one that differs may be a
    count in a row, and says that answers are not to be compared digit by digit.
    """
    whole = hashlib.sha256()
    tasks = plan.tasks("arctrue")[:first]
    for number, task in enumerate(sorted(tasks, key=set_name), start=1):
        say(f"set {number} of {len(tasks)}")
        folder = out / set_name(task)
        write_measurement_set(folder, make_set(task).measurement)
        for name, found in sorted(fingerprint(folder).items()):
            whole.update(f"{set_name(task)}/{name} {found}\n".encode())
    return whole.hexdigest()


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


def score_beside(folder: Path) -> dict[str, dict[str, Any]]:
    """The scores of every subject of which ``folder`` has results, over the sets that all have.

    Raises PlanError where there is no plan, AnswersError where there are no results.
    """
    plan = read_plan(folder)
    results = {
        name: {set_name(item.task): item for item in read_results([folder / name])}
        for name in SUBJECTS
        if (folder / name / HEADER).exists()
    }
    if not results:
        raise AnswersError(f"{folder}: no subject has answered yet: first arctrue benchmark run")
    common = set.intersection(*(set(items) for items in results.values()))
    order = [set_name(task) for task in plan.tasks("")]
    return {
        name: scored(judged((items[key].task, items[key].result) for key in order if key in common))
        for name, items in results.items()
    }


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
