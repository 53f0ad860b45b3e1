"""Fits the probabilities that a diagnosis states, and measures them across the two generators.

``python -m scripts.calibrate_probabilities`` reads the answers of ``stated.csv`` in
``studies/benchmark``, prints how well the coefficients fitted to one generator's answers hold on
the other's, and within each by five folds; ``--write`` writes those fitted to all into
``workbench/diagnose/calibrated.json``. ``--collect FOLDER`` (repeated) takes the answers of a
benchmark's runs in place of those in the table. Answers that say nothing (``cannot_tell``,
``bad_data``) state the probabilities beforehand and do not count.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from arctrue.base.whole_file import write_whole_text
from arctrue.studies.benchmark.answers import judged_sets
from arctrue.studies.benchmark.intervals import Estimate, calibration_error, log_score_gain
from arctrue.studies.benchmark.stated import (
    FILE,
    Stated,
    confidences,
    fitted,
    read_stated,
    stated,
    write_stated,
)
from arctrue.workbench.diagnose.calibrated import FEATURES, Calibration
from arctrue.workbench.diagnose.calibrated import FILE as COEFFICIENTS

FOLDS = 5
DIGITS = 5


def within(rows: Sequence[Stated]) -> list[float]:
    """Each fifth of the answers, every fifth one, by coefficients of the other four."""
    found = np.empty(len(rows))
    for fold in range(FOLDS):
        learned = fitted([row for place, row in enumerate(rows) if place % FOLDS != fold])
        found[fold::FOLDS] = confidences(rows[fold::FOLDS], learned)
    return [float(value) for value in found]


def words(found: Estimate) -> str:
    """Value and interval of 95 %."""
    return f"{found.value:.3f} ({found.low:.3f} … {found.high:.3f})"


def measured(what: str, probability: Sequence[float], rows: Sequence[Stated]) -> str:
    """One line: calibration error, and the log score less that of the best constant."""
    right = [row.right for row in rows]
    return (
        f"{what}: {len(rows)} answers, {sum(right)} right; calibration error "
        f"{words(calibration_error(probability, right))}, log score above a constant "
        f"{words(log_score_gain(probability, right))}"
    )


def lines(rows: Sequence[Stated]) -> list[str]:
    """Across and within the generators, and as the answers were stated when they were made."""
    generators = {
        name: [row for row in rows if row.generator == name]
        for name in ("simulated", "independent")
    }
    found, pooled, across = [], [], []
    for name, own in generators.items():
        others = [row for row in rows if row.generator != name]
        if not own or not others:
            continue
        probability = confidences(own, fitted(others))
        found.append(measured(f"{name}, fitted to the other", probability, own))
        found.append(measured(f"{name}, five folds", within(own), own))
        found.append(measured(f"{name}, as stated then", [row.probability for row in own], own))
        pooled += own
        across += probability
    if pooled:
        found.append(measured("both, each fitted to the other", across, pooled))
    return found


def data(learned: Calibration, answers: int) -> str:
    """The coefficients as JSON."""
    return (
        json.dumps(
            {
                "features": list(FEATURES),
                "answers": answers,
                "coefficients": np.round(learned.coefficients, DIGITS).tolist(),
                "covariance": np.round(learned.covariance, DIGITS).tolist(),
            },
            indent=1,
        )
        + "\n"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, and write what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--collect",
        type=Path,
        action="append",
        default=[],
        metavar="FOLDER",
        help="run of `arctrue benchmark` whose answers are stored first",
    )
    parser.add_argument("--write", action="store_true", help="write the coefficients")
    given = parser.parse_args(arguments)
    if given.collect:
        write_stated([row for place in given.collect for row in
                      stated(judged_sets([place], "arctrue", None))])  # fmt: skip
    rows = read_stated(FILE)
    for line in lines(rows):
        print(line)
    learned = fitted(rows)
    for name, value, sigma in zip(
        FEATURES, learned.coefficients, np.sqrt(np.diag(learned.covariance)), strict=True
    ):
        print(f"{name}: {value:.2f} ± {sigma:.2f}")
    if given.write:
        write_whole_text(COEFFICIENTS, data(learned, len(rows)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
