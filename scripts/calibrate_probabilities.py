"""Fits the coefficients of the probabilities that a diagnosis states, and scores the probabilities
on answers that were not used for the fit.

``python -m scripts.calibrate_probabilities`` reads the answers of ``stated.csv`` in
``studies/benchmark``. It prints the scores for three choices of such answers: those of the other
generator, of one world (a kind of noise and of wrong statements in the sets), and of a fifth of the
answers of each generator. ``--write`` writes the coefficients fitted to all answers into
``workbench/diagnose/calibrated.json``. ``--collect FOLDER`` (may be repeated) first replaces the
answers in ``stated.csv`` by those of a benchmark run. Answers with the verdict ``bad_data`` do not
count, because their probabilities do not depend on these coefficients.
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
from arctrue.studies.benchmark.perfect import perfect_calibration
from arctrue.studies.benchmark.score import INDEPENDENT, SIMULATED
from arctrue.studies.benchmark.stated import (
    FILE,
    Stated,
    confidences,
    fitted,
    read_stated,
    stated,
    write_stated,
)
from arctrue.workbench.diagnose.calibrated import FEATURES, KINDS, Calibration
from arctrue.workbench.diagnose.calibrated import FILE as COEFFICIENTS

FOLDS = 5
GENERATORS = (SIMULATED, INDEPENDENT)
DIGITS = 5


def within(rows: Sequence[Stated]) -> list[float]:
    """Return the probability of every answer; the coefficients for each fifth of the answers are
    fitted to the other four fifths."""
    found = np.empty(len(rows))
    for fold in range(FOLDS):
        learned = fitted([row for place, row in enumerate(rows) if place % FOLDS != fold])
        found[fold::FOLDS] = confidences(rows[fold::FOLDS], learned)
    return [float(value) for value in found]


def without_their_world(rows: Sequence[Stated]) -> list[float]:
    """Return the probability of every answer; the coefficients for each world are fitted to all
    other worlds of both generators."""
    found = np.empty(len(rows))
    for world in {row.world for row in rows}:
        own = [place for place, row in enumerate(rows) if row.world == world]
        learned = fitted([row for row in rows if row.world != world])
        found[own] = confidences([rows[place] for place in own], learned)
    return [float(value) for value in found]


def across(rows: Sequence[Stated]) -> list[float]:
    """Return the probability of every answer; the coefficients for each generator are fitted to the
    answers of the other generator."""
    found = np.empty(len(rows))
    for generator in GENERATORS:
        own = [place for place, row in enumerate(rows) if row.generator == generator]
        others = [row for row in rows if row.generator != generator]
        found[own] = confidences([rows[place] for place in own], fitted(others))
    return [float(value) for value in found]


def words(found: Estimate) -> str:
    """Format an estimate and its 95 % interval as a text."""
    return f"{found.value:.3f} ({found.low:.3f} … {found.high:.3f})"


def measured(what: str, pairs: Sequence[tuple[float, Stated]]) -> str:
    """Return a row of a table: calibration error, that of a perfect calibration, and the log score
    minus the log score of the best constant."""
    probability, right = [pair[0] for pair in pairs], [pair[1].right for pair in pairs]
    mean, most = perfect_calibration(probability)
    return (
        f"| {what} | {len(right)} | {sum(right)} "
        f"| {calibration_error(probability, right).value:.3f} | {mean:.3f}, {most:.3f} "
        f"| {words(log_score_gain(probability, right))} |"
    )


def table(rows: Sequence[Stated]) -> list[str]:
    """Return a table in Markdown: the scores for each choice of the answers to which the
    coefficients are fitted."""
    found = [
        "| Answers | Number | Right | Calibration error | Perfect: mean, 95 % "
        "| Log score above a constant |",
        "|---|---|---|---|---|---|",
    ]
    groups = {name: [row for row in rows if row.generator == name] for name in GENERATORS}
    if all(groups.values()):
        of_both = list(zip(across(rows), rows, strict=True))
        for name in GENERATORS:
            own = [pair for pair in of_both if pair[1].generator == name]
            found.append(measured(f"{name}, from the other", own))
        found.append(measured("both, from the other", of_both))
    pairs = list(zip(without_their_world(rows), rows, strict=True))
    for name in GENERATORS:
        own = [pair for pair in pairs if pair[1].generator == name]
        found.append(measured(f"{name}, from other worlds", own))
    found.append(measured("both, from other worlds", pairs))
    for name, own_rows in groups.items():
        own = list(zip(within(own_rows), own_rows, strict=True))
        found.append(measured(f"{name}, five folds", own))
    found.append(measured("both, as stated then", [(row.probability, row) for row in rows]))
    return found


def kinds(rows: Sequence[Stated]) -> list[str]:
    """Return the number of right answers of each kind, by generator."""
    found = []
    for kind in KINDS:
        said = []
        for name in GENERATORS:
            own = [row.right for row in rows if row.verdict == kind and row.generator == name]
            said.append(f"{sum(own)} of {len(own)} ({name})")
        found.append(f"{kind}: right {', '.join(said)}")
    return found


def data(learned: Calibration) -> str:
    """Return the calibration as the JSON text of ``calibrated.json``."""
    return (
        json.dumps(
            {
                "features": list(FEATURES),
                "answers": dict(learned.answers),
                "coefficients": np.round(learned.coefficients, DIGITS).tolist(),
                "covariance": np.round(learned.covariance, DIGITS).tolist(),
            },
            indent=1,
        )
        + "\n"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure the scores, and write the files that the options request."""
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
    for line in (*table(rows), "", *kinds(rows), ""):
        print(line)
    learned = fitted(rows)
    for name, value, sigma in zip(
        FEATURES, learned.coefficients, np.sqrt(np.diag(learned.covariance)), strict=True
    ):
        print(f"{name}: {value:.2f} ± {sigma:.2f}")
    if given.write:
        write_whole_text(COEFFICIENTS, data(learned))
    return 0


if __name__ == "__main__":
    sys.exit(main())
