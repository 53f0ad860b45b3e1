"""Runs one task of the benchmark: makes the set, lets the subject read the set, and returns truth
and answer."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from arctrue.measurement import write_measurement_set
from arctrue.studies.benchmark.digests import folder_digest
from arctrue.studies.benchmark.sets import make_set
from arctrue.studies.benchmark.subject import Answer, find_subject


def run_set(task: Mapping[str, Any]) -> dict[str, Any]:
    """Make the set of a task (see make_set) and run the task's ``subject``; return truth, digest
    and answer.

    If the subject fails, the answer is the verdict ``error`` with the exception; the benchmark
    scores it as a miss.
    """
    made = make_set(task)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "set"
        write_measurement_set(folder, made.measurement)
        found = folder_digest(folder)
        try:
            answer: Answer = find_subject(task["subject"])(folder)
        except Exception as error:
            answer = {"verdict": "error", "error": f"{type(error).__name__}: {error}"}
    return {"truth": made.truth, "set": found, "answer": answer}
