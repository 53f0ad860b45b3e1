"""One task of the benchmark: make the set, let the subject see its folder, keep both sides."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from arctrue.measurement import write_measurement_set
from arctrue.studies.benchmark.sets import make_set
from arctrue.studies.benchmark.subject import SUBJECTS, Answer


def run_set(task: Mapping[str, Any]) -> dict[str, Any]:
    """Truth and answer of the set of one task (see make_set) by its ``subject``.

    A subject that fails gives the verdict ``error`` with the exception, which is scored as a miss.
    """
    made = make_set(task)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "set"
        write_measurement_set(folder, made.measurement)
        try:
            answer: Answer = SUBJECTS[task["subject"]](folder)
        except Exception as error:
            answer = {"verdict": "error", "error": f"{type(error).__name__}: {error}"}
    return {"truth": made.truth, "answer": answer}
