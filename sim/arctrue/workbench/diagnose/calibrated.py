"""How often an answer of such a kind and such grounds is right: a logistic of few features.

Each kind of answer has a constant of its own, ``unknown`` one for each thing that it rests on; the
features have one coefficient for all kinds. The
coefficients are uncertain. An answer far from those that they were fitted to has an uncertain
value, and what is stated is the mean over it, which is nearer to one half (MacKay, Neural Comput. 4
(1992) 720). No answer is stated surer than answers of its kind have been counted (rule of
succession). ``python -m scripts.calibrate_probabilities`` fits the coefficients to ``stated.csv``
of the benchmark, whose sets are of two generators, and prints how well those of one hold on the
other.
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
"""Verdicts whose answers were counted. ``bad_data`` states what was probable beforehand."""
DISTANCES = ("untested", "left", "not_white", "few_repeats")
"""How far a set is from the benchmark's usual one: with more of these no answer is surer."""
FEATURES = ("constant", *KINDS, *RESTS_ON, "evidence", *DISTANCES)
"""Chosen by leave-one-world-out and across-generator scores of ``stated.csv``. The scores of the
chosen ones are a little optimistic; only answers made afterwards measure them without bias."""
SUREST_EVIDENCE = 1e-2
"""Evidence is taken no nearer to 0 or 1: likelihoods know no better whether a form is right."""
USUAL_RUNS, USUAL_VISITS = 4.0, 20.0
"""Of the benchmark's usual set: its runs, and how often a station is visited."""
MOST_LEFT = 10.0
"""RMS that is left, in noises of the repeats: what is farther off counts as so far."""
MOST_NOT_WHITE = 20.0
"""−log₁₀ p of whiteness: the same."""
LIKE_BENCHMARK = 2
"""In fewer ways unlike the benchmark (:mod:`distance`), a set is not said to be unlike it."""


@dataclass(frozen=True)
class Calibration:
    """The coefficients of FEATURES, (n,), their covariance, (n, n), and the answers by kind."""

    coefficients: Float
    covariance: Float
    answers: Mapping[str, int]

    def confidence(self, verdict: str, row: Float) -> float:
        """Mean of the logistic of a row (n,) of features over the uncertain coefficients.

        After n answers of a kind of which each one was right, the next one is with probability
        (n + 1)/(n + 2) (Laplace); nothing is stated nearer to 0 or 1 than that.
        """
        value = float(row @ self.coefficients)
        variance = float(row @ self.covariance @ row)
        least = 1.0 / (self.answers.get(verdict, 0) + 2.0)
        mean = float(expit(value / np.sqrt(1.0 + np.pi * variance / 8.0)))
        return min(max(mean, least), 1.0 - least)


def features(verdict: str, grounds: Grounds) -> Float:
    """The row of an answer, (n,): the evidence in log odds, distances from 0 upwards."""
    away = grounds.distance
    held = min(max(grounds.evidence, SUREST_EVIDENCE), 1.0 - SUREST_EVIDENCE)
    runs = away.runs / USUAL_RUNS if away.runs else 1.0
    visits = away.visits / USUAL_VISITS if away.visits else 1.0
    values = {
        "constant": 1.0,
        verdict: 1.0,
        grounds.rests_on: 1.0,
        # What cannot be told has none.
        "evidence": 0.0 if verdict == "cannot_tell" else float(logit(held)),
        "untested": away.untested,
        "left": float(np.log(min(max(away.left, 1.0), MOST_LEFT))),
        "not_white": min(away.not_white, MOST_NOT_WHITE) / MOST_NOT_WHITE,
        "few_repeats": -float(np.log(min(runs, visits, 1.0))),
    }
    return np.array([values.get(name, 0.0) for name in FEATURES])


def confidence(verdict: str, grounds: Grounds) -> float | None:
    """Probability that such an answer is right; None for a verdict that was not counted."""
    if verdict not in KINDS:
        return None
    return calibration().confidence(verdict, features(verdict, grounds))


@cache
def calibration() -> Calibration:
    """The one in use."""
    data = json.loads(FILE.read_text(encoding="utf-8"))
    return Calibration(
        np.array(data["coefficients"]), np.array(data["covariance"]), data["answers"]
    )
