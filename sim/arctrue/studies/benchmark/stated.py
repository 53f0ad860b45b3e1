"""Stores the answers of a benchmark as rows of a CSV table: the grounds of each answer, and whether
the answer is right.

The logistic regression of :mod:`arctrue.workbench.diagnose.calibrated` is fitted to these rows.
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import expit, log_expit

from arctrue.base.whole_file import write_whole_text
from arctrue.studies.benchmark.independent.world import independent_worlds
from arctrue.studies.benchmark.outcome import Judged
from arctrue.workbench.diagnose.calibrated import (
    DISTANCES,
    FEATURES,
    KINDS,
    Calibration,
    features,
)
from arctrue.workbench.diagnose.distance import Distance
from arctrue.workbench.diagnose.grounds import RESTS_ON, Grounds
from arctrue.workbench.diagnose.posterior import SAID

Float = NDArray[np.float64]

FILE = Path(__file__).with_name("stated.csv")
"""File of the answers to which the present coefficients were fitted."""
PRIOR_SIGMA = (
    {"constant": 3.0, "evidence": 1.0}
    | dict.fromkeys((*KINDS, *RESTS_ON), 1.0)
    | dict.fromkeys(DISTANCES, 0.1)
)
"""Standard deviation of each coefficient's normal prior with mean 0. The priors allow a share of
right answers from 5 to 95 %, a factor of about 3 in the odds between kinds, and the full log odds
of the evidence; a distance of 1 changes the odds by about 10 % unless the answers show a different
change."""


@dataclass(frozen=True, slots=True)
class Stated:
    """Row of the table: an answer that states probabilities."""

    generator: str
    world: str
    verdict: str
    rests_on: str
    """Kind of evidence for the verdict ``unknown``; empty for other verdicts."""
    right: bool
    """Whether the answer's verdict is right; for a verdict that names nothing, whether the largest
    stated probability is right."""
    probability: float
    """Largest probability that the answer stated when it was made."""
    evidence: float
    untested: float
    runs: int
    visits: float
    left: float
    not_white: float
    ways: int

    @property
    def grounds(self) -> Grounds:
        """Return the grounds in the type that the diagnosis uses; values that no feature of the
        regression uses are 0."""
        away = Distance(self.untested, self.runs, self.visits, self.left, self.not_white)
        return Grounds(self.evidence, 0.0, 0.0, 0.0, None, 0.0, 0, self.ways, away, self.rests_on)


def stated(sets: Iterable[Judged]) -> list[Stated]:
    """Return a row for every set whose answer states probabilities, has grounds, and has a verdict
    of KINDS."""
    found = []
    for item in sets:
        pair, grounds = item.first_probability(), item.answer.get("grounds")
        if pair is None or grounds is None or item.answer["verdict"] not in KINDS:
            continue
        away: Mapping[str, Any] = grounds["distance"]
        found.append(
            Stated(
                "independent" if item.world in independent_worlds() else "simulated",
                item.world,
                item.answer["verdict"],
                grounds["rests_on"],
                _right(item, pair[1]),
                pair[0],
                float(f"{grounds['evidence']:.6g}"),
                round(float(away["untested"]), 4),
                int(away["runs"]),
                float(away["visits"]),
                float(f"{away['left']:.4g}"),
                float(f"{away['not_white']:.4g}"),
                int(grounds["ways"]),
            )
        )
    return found


def _right(item: Judged, first: bool) -> bool:
    """Tell whether the answer's verdict is right; the stated probabilities do not matter.

    ``first``: whether the answer's largest stated probability was right; this is the result for an
    answer that names nothing.
    """
    members = item.answer.get("class") or []
    said = next(iter(SAID.get(item.answer["verdict"], members)), None)
    if said is None:
        return first
    alone = replace(item, answer={**item.answer, "probability": {said: 1.0}}).first_probability()
    return alone is not None and alone[1]


def write_stated(rows: Sequence[Stated], path: Path = FILE) -> None:
    """Write the rows as CSV, in the order given."""
    text = StringIO()
    table = csv.DictWriter(text, [item.name for item in fields(Stated)], lineterminator="\n")
    table.writeheader()
    table.writerows({**asdict(row), "right": int(row.right)} for row in rows)
    write_whole_text(path, text.getvalue())


def read_stated(path: Path = FILE) -> list[Stated]:
    """Read the file that :func:`write_stated` wrote."""
    with path.open(newline="", encoding="utf-8") as file:
        return [
            Stated(
                row["generator"],
                row["world"],
                row["verdict"],
                row["rests_on"],
                row["right"] == "1",
                float(row["probability"]),
                float(row["evidence"]),
                float(row["untested"]),
                int(row["runs"]),
                float(row["visits"]),
                float(row["left"]),
                float(row["not_white"]),
                int(row["ways"]),
            )
            for row in csv.DictReader(file)
        ]


def fitted(rows: Sequence[Stated]) -> Calibration:
    """Fit the coefficients of greatest posterior density, and compute their covariance (Laplace's
    approximation).

    The log likelihood of right and wrong answers is combined with normal priors; coefficients of
    the distances are at most 0, the coefficient of the evidence is at least 0.
    """
    design = np.array([features(row.verdict, row.grounds) for row in rows])
    answers = Counter(row.verdict for row in rows)
    sign = np.where([row.right for row in rows], 1.0, -1.0)
    sigma = np.array([PRIOR_SIGMA[name] for name in FEATURES])

    def cost(weights: Float) -> tuple[float, Float]:
        odds = sign * (design @ weights)
        slope = -(design.T @ (sign * expit(-odds))) + weights / sigma**2
        return float(-log_expit(odds).sum() + 0.5 * np.sum((weights / sigma) ** 2)), slope

    limits = {"evidence": (0.0, None)} | dict.fromkeys(DISTANCES, (None, 0.0))
    bounds = [limits.get(name, (None, None)) for name in FEATURES]
    found = minimize(cost, np.zeros(len(FEATURES)), jac=True, method="L-BFGS-B", bounds=bounds)
    right = expit(design @ found.x)
    information = (design.T * (right * (1.0 - right))) @ design + np.diag(sigma**-2.0)
    covariance = np.linalg.inv(information)
    away = np.isin(FEATURES, DISTANCES)
    # Correlations of a distance are set to 0: the variance then rises with each distance, so that
    # the uncertainty never falls as a set's distance rises.
    covariance[away] = covariance[:, away] = 0.0
    covariance[away, away] = np.diag(np.linalg.inv(information))[away]
    return Calibration(np.asarray(found.x), covariance, {kind: answers[kind] for kind in KINDS})


def confidences(rows: Sequence[Stated], learned: Calibration) -> list[float]:
    """Return the probability that each answer would state with the calibration ``learned``."""
    return [learned.confidence(row.verdict, features(row.verdict, row.grounds)) for row in rows]
