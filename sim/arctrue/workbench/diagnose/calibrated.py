"""How often an answer that rests on such grounds is right: a logistic of few features.

Its coefficients are uncertain. An answer far from those that they were fitted to has an uncertain
value, and what is stated is the mean over it, which is nearer to one half (MacKay, Neural Comput. 4
(1992) 720). ``python -m scripts.calibrate_probabilities`` fits them to ``stated.csv`` of the
benchmark, whose sets are of two generators, and prints how well those of one hold on the other.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, logit

from arctrue.workbench.diagnose.grounds import Grounds

Float = NDArray[np.float64]

FILE = Path(__file__).with_name("calibrated.json")
SAYING = frozenset({"named", "ambiguous", "unknown", "adequate"})
"""Verdicts that say something; the others state what was probable beforehand."""
DISTANCES = ("untested", "left", "not_white", "few_repeats")
"""How far a set is from the benchmark's usual one: with more of these no answer is surer."""
FEATURES = ("constant", "class", "evidence", *DISTANCES)
"""Chosen on the answers that they are fitted to: many variants (other features, with and without
a constant of each kind of answer, other priors, other limits) were scored across the generators,
and the best was kept. The scores across the generators are therefore optimistic; only answers made
afterwards measure the calibration without this bias."""
SUREST_EVIDENCE = 1e-2
"""Evidence is taken no nearer to 0 or 1: of 10⁻², 10⁻³ and 10⁻⁴ the best by these scores."""
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
    """The coefficients of FEATURES, (n,), and their covariance, (n, n)."""

    coefficients: Float
    covariance: Float

    def confidence(self, row: Float) -> float:
        """Mean of the logistic of a row (n,) of features over the uncertain coefficients."""
        value = float(row @ self.coefficients)
        variance = float(row @ self.covariance @ row)
        return float(expit(value / np.sqrt(1.0 + np.pi * variance / 8.0)))


def features(verdict: str, grounds: Grounds) -> Float:
    """The row of an answer, (n,): the evidence in log odds, distances from 0 upwards."""
    away = grounds.distance
    held = min(max(grounds.evidence, SUREST_EVIDENCE), 1.0 - SUREST_EVIDENCE)
    runs = away.runs / USUAL_RUNS if away.runs else 1.0
    visits = away.visits / USUAL_VISITS if away.visits else 1.0
    values = {
        "constant": 1.0,
        "class": float(verdict == "ambiguous"),
        "evidence": float(logit(held)),
        "untested": away.untested,
        "left": float(np.log(min(max(away.left, 1.0), MOST_LEFT))),
        "not_white": min(away.not_white, MOST_NOT_WHITE) / MOST_NOT_WHITE,
        "few_repeats": -float(np.log(min(runs, visits, 1.0))),
    }
    return np.array([values.get(name, 0.0) for name in FEATURES])


def confidence(verdict: str, grounds: Grounds) -> float | None:
    """Probability that such an answer is right; None for a verdict that says nothing."""
    return calibration().confidence(features(verdict, grounds)) if verdict in SAYING else None


@cache
def calibration() -> Calibration:
    """The one in use."""
    data = json.loads(FILE.read_text(encoding="utf-8"))
    return Calibration(np.array(data["coefficients"]), np.array(data["covariance"]))
