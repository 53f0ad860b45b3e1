"""Compares the output of ``diagnose --json`` for 40 benchmark sets with recorded output.

The record contains verdicts, names, numbers and keys, but no sentences, because these may be
reworded. ``python -m scripts.record_verdicts`` writes the record.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from arctrue.studies.benchmark.diagnosis import diagnosed
from arctrue.studies.benchmark.digests import set_name
from arctrue.studies.benchmark.plan import TIERS
from arctrue.studies.benchmark.sets import make_set
from arctrue.studies.benchmark.tasks import set_tasks
from arctrue.studies.benchmark.worlds import FOUR_HEADS
from arctrue.studies.campaign import Task
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.model.model import default_model

RECORD = Path(__file__).parent / "recorded_verdicts.jsonl"
SETS = 40
WHOLE_CANDIDATES = 3
"""Number of candidates with a complete record; of the other candidates, only name and evidence are
recorded."""
DIGITS = 7
RELATIVE = 1e-3
"""Largest relative difference of two numbers that count as equal.

The fit of the noise stops when a round gains less than 0.01 of log likelihood; another order of
summation may therefore change the fourth digit of a result.
"""
LEAST = 1e-6
"""Absolute difference, in arcseconds or in the unit of a parameter, below which two numbers count
as equal."""
SMALLEST_P = 1e-300
EVIDENCE = 0.02
"""Largest difference of two values of ΔBIC that count as equal: twice the tolerance of the log
likelihood."""
SENTENCES = {
    "description",
    "unlike",
    "next_measurement",
    "cannot_tell",
    "reason",
    "unlike_benchmark",
}
LACKING = {"cannot_be_tested", "look_alikes"}
"""Keys under which each effect has a sentence about what the set lacks."""


def tasks() -> list[Task]:
    """Return the tasks of the first sets with two heads of the tier ``quick``, six or seven of each
    world."""
    tier = TIERS["quick"]
    assert tier.seed is not None
    found = set_tasks(tier.sets, tier.samples, tier.seed, "")
    return [task for task in found if task["world"] != FOUR_HEADS][:SETS]


def verdict_of(task: Task) -> dict[str, Any]:
    """Return the output of ``diagnose --json`` for the set of this task, without its sentences."""
    _, found = diagnosed(make_set(task).measurement)
    data = diagnosis_data(found, default_model().names())
    candidates = data["candidates"]
    short = [
        {key: item[key] for key in ("effect", "p_corrected", "delta_bic")}
        for item in candidates[WHOLE_CANDIDATES:]
    ]
    data["candidates"] = candidates[:WHOLE_CANDIDATES] + short
    return {"set": set_name(task), **_without_sentences(data)}


def recorded() -> dict[str, dict[str, Any]]:
    """Return the recorded verdicts, keyed by the names of the sets."""
    lines = RECORD.read_text(encoding="utf-8").splitlines()
    return {item["set"]: item for item in map(json.loads, lines)}


def line_of(verdict: Mapping[str, Any]) -> str:
    """Return the verdict as one line of the record."""
    return json.dumps(_rounded(verdict), separators=(",", ":"), sort_keys=True)


def differences(before: Any, now: Any, place: str = "") -> Iterator[str]:
    """Yield a sentence for each place at which two verdicts differ by more than the tolerance."""
    if isinstance(before, Mapping) and isinstance(now, Mapping):
        for key in sorted({*before, *now}):
            if key not in before or key not in now:
                yield f"{place}/{key}: {'was not there' if key not in before else 'is gone'}"
            else:
                yield from differences(before[key], now[key], f"{place}/{key}")
    elif isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        for number, (old, new) in enumerate(zip(before, now, strict=True)):
            yield from differences(old, new, f"{place}/{number}")
    elif not _equal(before, now, place.rsplit("/", 1)[-1]):
        yield f"{place}: was {before}, is {now}"


def _equal(before: Any, now: Any, key: str) -> bool:
    numbers = all(isinstance(item, int | float) and item is not True for item in (before, now))
    if not numbers or before == now:
        return bool(before == now)
    if key == "p_corrected" or key.endswith(("_p", "p_value")):
        before, now = (math.log(max(item, SMALLEST_P)) for item in (before, now))
    least = EVIDENCE if key == "delta_bic" else LEAST
    return math.isclose(before, now, rel_tol=RELATIVE, abs_tol=least)


def _without_sentences(data: Any, key: str = "") -> Any:
    if isinstance(data, Mapping):
        if key in LACKING:
            return sorted(data)
        return {name: _without_sentences(value, name) for name, value in data.items()}
    if key in SENTENCES:
        return data is not None
    if key in ("data_faults", "lacking_variety"):
        return len(data)
    if isinstance(data, list):
        return [_without_sentences(item) for item in data]
    return None if isinstance(data, float) and not math.isfinite(data) else data


def _rounded(data: Any) -> Any:
    if isinstance(data, Mapping):
        return {key: _rounded(value) for key, value in data.items()}
    if isinstance(data, list):
        return [_rounded(item) for item in data]
    return float(f"{data:.{DIGITS}g}") if isinstance(data, float) else data
