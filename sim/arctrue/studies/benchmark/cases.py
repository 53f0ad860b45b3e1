"""Stores the sets on which the diagnosis once failed and the reasons, so that later versions of the
diagnosis are tested on them."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from arctrue.base.whole_file import write_whole_text
from arctrue.studies.benchmark.digests import set_name
from arctrue.studies.benchmark.outcome import Judged
from arctrue.studies.campaign.task import Task

FILE = Path(__file__).with_name("cases.json")
OF_A_SET = ("world", "content", "seed", "samples")


@dataclass(frozen=True, slots=True)
class Reason:
    """Reason of a failure; a person has found the reason and written it into the file of cases."""

    said: str
    """Answer that the reason explains; a different answer to the same set may have another
    reason."""
    why: str


def kept_cases(file: Path = FILE) -> list[dict[str, Any]]:
    """Read every case: the task of its set, ``found`` and ``looked_into``.

    ``found``: the hidden content, the answer, and the commit; ``looked_into``: a Reason, if a
    person has studied the case.
    """
    found: list[dict[str, Any]] = json.loads(file.read_text(encoding="utf-8"))["cases"]
    return found


def case_tasks(subject: str, file: Path = FILE) -> list[Task]:
    """Return the sets of all cases as tasks."""
    return [
        {**{name: case[name] for name in OF_A_SET}, "subject": subject} for case in kept_cases(file)
    ]


def kept_reasons(file: Path = FILE) -> dict[str, Reason]:
    """Return the reason of every studied case, by the name of its set (see set_name)."""
    return {
        _name(case): Reason(**case["looked_into"])
        for case in kept_cases(file)
        if "looked_into" in case
    }


def keep(failures: Iterable[Judged], commit: str | None, file: Path = FILE) -> int:
    """Add the failures that are not yet cases; return their number."""
    cases = kept_cases(file)
    known = {_name(case) for case in cases}
    new = [item for item in failures if set_name(item.task) not in known]
    cases += [_case(item, commit) for item in new]
    text = json.dumps({"cases": cases}, indent=1, ensure_ascii=False)
    write_whole_text(file, text + "\n")
    return len(new)


def _name(case: Mapping[str, Any]) -> str:
    return set_name({name: case[name] for name in OF_A_SET})


def _case(item: Judged, commit: str | None) -> dict[str, Any]:
    found = {"hidden": item.hidden, "said": item.said, "outcome": item.outcome, "commit": commit}
    return {**{name: item.task[name] for name in OF_A_SET}, "found": found}
