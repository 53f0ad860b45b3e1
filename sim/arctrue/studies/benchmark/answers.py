"""Scores the answers that a benchmark run has stored, or answers of another program from a file."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Literal

from msgspec import Struct

from arctrue.base.printable import one_line
from arctrue.base.progress import ReportStep
from arctrue.base.typed_content import ContentError, NotNegative, read_json, typed, unknown_keys
from arctrue.measurement import write_measurement_set
from arctrue.studies.benchmark.digests import folder_digest, set_name
from arctrue.studies.benchmark.frozen import differing, is_public
from arctrue.studies.benchmark.outcome import Judged
from arctrue.studies.benchmark.plan import FILE, TIERS, TierPlan, read_plan
from arctrue.studies.benchmark.score import judged, scored
from arctrue.studies.benchmark.sets import make_set
from arctrue.studies.benchmark.subject import SUBJECTS
from arctrue.studies.campaign import Result, read_results
from arctrue.studies.campaign.code_state import LIBRARIES
from arctrue.studies.campaign.store import HEADER, read_header

Verdict = Literal["adequate", "named", "ambiguous", "unknown", "cannot_tell", "bad_data", "error"]
"""Verdicts that an answer may have; ``error`` means that the subject gave no answer."""


class _Answer(Struct, rename={"effects": "class"}):
    """Keys of an answer that the benchmark scores; an answer may have further keys."""

    verdict: Verdict
    named: str | None = None
    effects: list[str] | None = None
    parts: list[str] | None = None
    further: list[str] | None = None
    probability: dict[str, NotNegative] | None = None
    parameters: dict[str, float] | None = None
    """Parameters of the named effect; for a sine in angle or time, ``order`` (per turn) or
    ``frequency`` (Hz).
    """
    oscillation_hz: float | None = None
    """Frequency, in Hz, of a damped oscillation that noise drives; None if the answer states no
    oscillation."""
    held_out_arcsec: dict[str, NotNegative] | None = None


class AnswersError(ValueError):
    """Raised if answers cannot be scored: the file is invalid, there are no results, or the results
    belong to different plans, sets or libraries."""


def write_sets(
    plan: TierPlan, out: Path, first: int | None, report_step: ReportStep
) -> dict[str, str]:
    """Write the first ``first`` sets of a plan (None: all), each into a folder; return digests by
    name.

    Two machines compute equal digests if their sines and cosines agree to the last bit. A
    difference of one count in one row changes a digest; do not compare the answers of two machines
    digit by digit if their digests differ.
    """
    tasks = plan.tasks("arctrue")[:first]
    found = {}
    for number, task in enumerate(sorted(tasks, key=set_name), start=1):
        report_step(f"set {number} of {len(tasks)}")
        folder = out / set_name(task)
        write_measurement_set(folder, make_set(task).measurement)
        found[set_name(task)] = folder_digest(folder)
    return found


def score_folders(folders: Sequence[Path], subject: str, answers: Path | None) -> dict[str, Any]:
    """Score the stored results of one subject, or, if ``answers`` is given, the answers in this
    file instead.

    Raises the exceptions of judged_sets.
    """
    return scored(judged_sets(folders, subject, answers))


def judged_sets(folders: Sequence[Path], subject: str, answers: Path | None) -> list[Judged]:
    """Return every set of one subject's results with truth and answer, in the order of the plan.

    Raises PlanError if there is no plan, or if the plan's seed was drawn at random and the code of
    the generator or of the scoring has changed since the plan was made. Raises AnswersError for an
    invalid file of answers, or for results of another plan.
    """
    plan = read_plan(folders[0])
    if TIERS[plan.tier].seed is None:
        plan.check()
    results = read_results([folder / subject for folder in folders])
    _check_plan(folders[0], plan, subject)
    sets = judged((item.task, item.result) for item in results)
    if answers is not None:
        sets = _answered(sets, answers)
    order = {json.dumps(task, sort_keys=True): at for at, task in enumerate(plan.tasks(subject))}
    sets.sort(key=lambda item: order.get(json.dumps(item.task, sort_keys=True), len(order)))
    return sets


def score_of_peers(folder: Path) -> dict[str, dict[str, Any]]:
    """Score every subject with results in ``folder`` on the sets that all subjects have.

    Each score contains the ``header`` of the campaign that made its answers. All answers of one
    subject come from one state of the code (see sources_of); two subjects may come from different
    states. Raises PlanError if there is no plan, and AnswersError if there are no results, if two
    subjects have different sets or libraries, or if a set differs from the frozen set of its name.
    """
    plan = read_plan(folder)
    results = {
        name: {set_name(item.task): item for item in read_results([folder / name])}
        for name in SUBJECTS
        if (folder / name / HEADER).exists()
    }
    if not results:
        raise AnswersError(f"{folder}: no subject has answered yet: first arctrue benchmark run")
    headers = {name: _check_plan(folder, plan, name) for name in results}
    first, *others = (
        (name, {library: header["code"].get(library) for library in LIBRARIES})
        for name, header in headers.items()
    )
    for name, libraries in others:
        if libraries != first[1]:
            raise AnswersError(
                f"{folder}: {first[0]} calculated with {first[1]}, {name} with {libraries}: "
                "results of two states are not mixed; run one of them again in a new folder"
            )
    if is_public(plan):
        for name, items in results.items():
            _check_frozen(folder / name, items)
    common = set.intersection(*(set(items) for items in results.values()))
    order = [key for task in plan.tasks("") if (key := set_name(task)) in common]
    if not order:
        raise AnswersError(f"{folder}: there is no set yet that {', '.join(results)} have answered")
    # Score all subjects with the same truth, because the generator may have changed between their
    # runs.
    truth = {key: item.result["truth"] for key, item in results[first[0]].items()}
    return {
        name: {
            **scored(
                [Judged(items[key].task, truth[key], items[key].result["answer"]) for key in order]
            ),
            "header": headers[name],
        }
        for name, items in results.items()
    }


def _check_frozen(folder: Path, results: Mapping[str, Result]) -> None:
    """Raise AnswersError if a set differs from the frozen set of its name."""
    other = differing({key: item.result.get("set", "") for key, item in results.items()})
    if other:
        raise AnswersError(
            f"{folder}: {len(other)} of {len(results)} answers are to other sets than the frozen "
            f"ones, the first is {other[0]}: results of two states are not mixed"
        )


def _check_plan(folder: Path, plan: TierPlan, subject: str) -> dict[str, Any]:
    """Check that a subject's results belong to the plan; return their header.

    Raises AnswersError if the results belong to another plan.
    """
    header = read_header(folder / subject)
    if header.get("plan") != asdict(plan):
        raise AnswersError(
            f"{folder / subject} has answers to the sets of another plan than "
            f"{folder / FILE}: results of two states are not mixed"
        )
    return header


def _answered(sets: Sequence[Judged], path: Path) -> list[Judged]:
    try:
        given = read_json(path, dict[str, dict[str, Any]])
    except ContentError as error:
        raise AnswersError(f"{error} (one answer a set, by its name)") from None
    names = {set_name(item.task): item for item in sets}
    strange = sorted(set(given) - set(names))
    if strange:
        raise AnswersError(f"{path}: no set is called {strange[0]!r}")
    missing = sorted(set(names) - set(given))
    if missing:
        raise AnswersError(f"{path}: {len(missing)} sets have no answer, the first is {missing[0]}")
    for name, answer in given.items():
        if "beside" in answer:
            # "beside" is the former name of the key "further"; it is still read for one release.
            answer.setdefault("further", answer.pop("beside"))
        try:
            typed(answer, _Answer, name)
        except ContentError as error:
            raise AnswersError(f"{path}: {error}") from None
        for key, near in unknown_keys(answer, _Answer).items():
            if near and near[0] not in answer:
                raise AnswersError(
                    f"{path}: {name}.{one_line(key)}: is not known; did you mean {near[0]}?"
                )
    return [Judged(item.task, item.truth, given[name]) for name, item in names.items()]
