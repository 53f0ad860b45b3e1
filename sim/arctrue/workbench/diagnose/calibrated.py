"""Calculates the probability that an answer of a given kind is right, as a logistic function of
features.

Each kind of answer (each verdict, and each ground of ``unknown``) has its own constant; the
coefficient of a feature is the same for all kinds. The coefficients are uncertain, so that the
value is uncertain for an answer whose features differ from those of the fitted answers. The stated
probability is the mean over this uncertainty; the mean is nearer to one half than the value itself
(MacKay, Neural Comput. 4 (1992) 720). The number of counted answers with the same
verdict limits the stated probability of an answer (rule of succession).

``python -m scripts.calibrate_probabilities`` fits the coefficients to ``stated.csv`` of the
benchmark, whose sets come from two generators, and prints the score of one generator's coefficients
on the sets of the other generator.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, logit

from arctrue.workbench.diagnose.grounds import RESTS_ON, Grounds

Float = NDArray[np.float64]

FILE = Path(__file__).with_name("calibrated.json")
KINDS = ("named", "ambiguous", "unknown", "adequate", "cannot_tell")
"""Verdicts for which right and wrong answers were counted; for ``bad_data`` a diagnosis states the
prior probabilities."""
DISTANCES = ("untested", "left", "not_white", "few_repeats")
"""Features that measure the distance of a set from the benchmark's usual set; larger values never
increase a probability that is above one half. The counted answers show no dependence: the
coefficients are 0, and only their uncertainty moves a probability, by less than 0.01 towards one
half."""
FEATURES = ("constant", *KINDS, *RESTS_ON, "evidence", *DISTANCES)
"""Features of the logistic function, chosen by their scores on answers of ``stated.csv`` that were
left out of the fit: each fit left out the answers for one of the benchmark's kinds of data
(``world``) or for one generator. The scores of the chosen features are a little optimistic; only
answers that were made after the choice measure the features without bias."""
SUREST_EVIDENCE = 1e-2
"""The evidence, a probability, is kept at least this far from 0 and from 1; likelihoods do not
determine a probability more exactly."""
USUAL_RUNS, USUAL_VISITS = 4.0, 20.0
"""Number of runs, and of visits of a station, in the benchmark's usual set."""
MOST_LEFT = 10.0
"""Largest ratio of the remaining RMS to the noise of the repeats; larger ratios are replaced by
this limit."""
MOST_NOT_WHITE = 20.0
"""Largest −log₁₀ p of whiteness; larger values are replaced by this limit."""
LIKE_BENCHMARK = 2
"""A set is reported as unlike the benchmark if it has at least this number of differences
(:mod:`distance`)."""


@dataclass(frozen=True)
class Calibration:
    """Coefficients of FEATURES, (n,), their covariance, (n, n), and the counted answers by kind."""

    coefficients: Float
    covariance: Float
    answers: Mapping[str, int]

    def confidence(self, verdict: str, row: Float) -> float:
        """Return the mean of the logistic function of a row (n,) of features over the uncertain
        coefficients.

        If n answers of a kind were all right, the next answer is right with probability (n + 1)/(n
        + 2) (Laplace); this limits the stated probability from above, and in the same way from
        below.
        """
        value = float(row @ self.coefficients)
        variance = float(row @ self.covariance @ row)
        least = 1.0 / (self.answers.get(verdict, 0) + 2.0)
        mean = float(expit(value / np.sqrt(1.0 + np.pi * variance / 8.0)))
        return min(max(mean, least), 1.0 - least)


def features(verdict: str, grounds: Grounds) -> Float:
    """Return the features of an answer, (n,): evidence in log odds, and distances of at least 0."""
    away = grounds.distance
    held = min(max(grounds.evidence, SUREST_EVIDENCE), 1.0 - SUREST_EVIDENCE)
    runs = away.runs / USUAL_RUNS if away.runs else 1.0
    visits = away.visits / USUAL_VISITS if away.visits else 1.0
    values = {
        "constant": 1.0,
        verdict: 1.0,
        grounds.rests_on: 1.0,
        # The verdict ``cannot_tell`` has no evidence.
        "evidence": 0.0 if verdict == "cannot_tell" else float(logit(held)),
        "untested": away.untested,
        "left": float(np.log(min(max(away.left, 1.0), MOST_LEFT))),
        "not_white": min(away.not_white, MOST_NOT_WHITE) / MOST_NOT_WHITE,
        "few_repeats": -float(np.log(min(runs, visits, 1.0))),
    }
    return np.array([values.get(name, 0.0) for name in FEATURES])


def confidence(verdict: str, grounds: Grounds) -> float | None:
    """Return the probability that an answer with these grounds is right; None if KINDS lacks the
    verdict."""
    if verdict not in KINDS:
        return None
    return calibration().confidence(verdict, features(verdict, grounds))


@cache
def calibration() -> Calibration:
    """Read the calibration that is stored in the package."""
    data = json.loads(FILE.read_text(encoding="utf-8"))
    return Calibration(
        np.array(data["coefficients"]), np.array(data["covariance"]), data["answers"]
    )
