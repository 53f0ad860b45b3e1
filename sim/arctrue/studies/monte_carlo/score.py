"""Measures the coverage of the stated uncertainty: the share of trials whose region contains the
truth."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binomtest, chi2, norm

from arctrue.studies.monte_carlo.inputs import CASES
from arctrue.studies.monte_carlo.trial import ORDERS

Float = NDArray[np.float64]

COVERAGE = 0.95
SQUARE_LIMIT = float(chi2.ppf(COVERAGE, 2))
"""Limit below which the squared deviation of two components, in units of their covariance, lies
with the probability COVERAGE."""
FACTOR = float(norm.ppf(0.5 + COVERAGE / 2))
FACTOR_ALPHA = COVERAGE * math.sqrt(3.0)
"""Coverage factor of α, whose main uncertainty, the place of the index sensors, has a rectangular
distribution."""
FALSE_ALARM = 0.01
"""Probability that, by chance alone, at least one tested coverage of a case counts as too small or
too large."""


@dataclass(frozen=True, slots=True)
class Covered:
    """Number of trials whose stated region contains the truth, and the verdict on the
    uncertainty."""

    hits: int
    trials: int
    figures: int
    """Number of coverages of the case that are tested together."""

    @property
    def rate(self) -> float:
        """Return the share of trials whose region contains the truth; NaN without a trial."""
        return self.hits / self.trials if self.trials else float("nan")

    @property
    def verdict(self) -> str:
        """Return ``too small`` or ``too large`` if the coverage shows that the stated uncertainty
        is too small or too large; otherwise return an empty text."""
        if not self.trials:
            return ""
        found = binomtest(self.hits, self.trials).proportion_ci(
            1.0 - FALSE_ALARM / self.figures, method="exact"
        )
        if found.high < COVERAGE:
            return "too small"
        return "too large" if found.low > COVERAGE else ""

    def data(self) -> dict[str, Any]:
        """Return the score as values for JSON."""
        return {
            "hits": self.hits,
            "trials": self.trials,
            "rate": self.rate if self.trials else None,
            "stated_uncertainty": self.verdict or "holds",
        }


def scored(results: Sequence[tuple[Mapping[str, Any], Mapping[str, Any]]]) -> dict[str, Any]:
    """Return, for each case, the coverage of every order, of α and over the turn, with the RMS
    deviation and the stated u."""
    found = {}
    for case in CASES:
        trials = [result for task, result in results if task["case"] == case]
        if trials:
            found[case] = _case(trials)
    return found


def _case(trials: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    sound = [trial for trial in trials if "refused" not in trial]
    refused: dict[str, int] = {}
    for trial in trials:
        if "refused" in trial:
            refused[trial["refused"]] = refused.get(trial["refused"], 0) + 1
    if not sound:
        return {"trials": len(trials), "refused": refused}
    square = _stacked(sound, "square")
    deviation, variance = _stacked(sound, "deviation_arcsec2"), _stacked(sound, "variance_arcsec2")
    u_turn = _stacked(sound, "u_turn_arcsec")
    # The tested coverages are those of all orders, of α, and of two curves over the turn.
    figures = ORDERS + 3
    return {
        "trials": len(trials),
        "refused": refused,
        "orders": [
            {
                "order": at + 1,
                **Covered(int(np.sum(square[:, at] <= SQUARE_LIMIT)), len(sound), figures).data(),
                "rms_deviation_arcsec": float(np.sqrt(deviation[:, at].mean())),
                "rms_stated_arcsec": float(np.sqrt(variance[:, at].mean())),
            }
            for at in range(ORDERS)
        ],
        "alpha": _alpha([t["alpha"] for t in sound if t["alpha"] is not None], figures),
        "turn": _turn(_stacked(sound, "turn_arcsec"), u_turn, figures),
        "corrected": _turn(_stacked(sound, "corrected_arcsec"), u_turn, figures),
    }


def _alpha(pairs: Sequence[Sequence[float]], figures: int) -> dict[str, Any] | None:
    """Return the coverage of α; None if α was not drawn."""
    if not pairs:
        return None
    off, u = np.asarray(pairs, dtype=np.float64).T
    return {
        **Covered(int(np.sum(np.abs(off) <= FACTOR_ALPHA * u)), off.size, figures).data(),
        "rms_deviation_arcsec": float(np.sqrt(np.mean(off**2))),
        "rms_stated_arcsec": float(np.sqrt(np.mean(u**2))),
    }


def _stacked(trials: Sequence[Mapping[str, Any]], name: str) -> Float:
    return np.array([trial[name] for trial in trials], dtype=np.float64)


def _turn(off: Float, u: Float, figures: int) -> dict[str, Any]:
    """Compute the coverage at each reading; the test uses the mean coverage, because the errors at
    different angles of a trial are correlated."""
    covered = np.abs(off) <= FACTOR * u
    by_place, by_trial = covered.mean(axis=0), covered.mean(axis=1)
    rate = float(by_trial.mean())
    # The rate is the mean of the trials' shares of covered angles. The standard deviation of these
    # shares is taken as at least half the share of one angle.
    error = max(float(by_trial.std(ddof=1)) if off.shape[0] > 1 else 1.0, 0.5 / off.shape[1])
    error /= float(np.sqrt(off.shape[0]))
    off_by = (rate - COVERAGE) / error
    limit = float(norm.isf(FALSE_ALARM / figures / 2))
    verdict = "holds"
    if abs(off_by) > limit:
        verdict = "too small" if off_by < 0 else "too large"
    return {
        "rate": rate,
        "standard_error": error,
        "least_of_a_place": float(by_place.min()),
        "stated_uncertainty": verdict,
        "rms_deviation_arcsec": float(np.sqrt(np.mean(off**2))),
        "rms_stated_arcsec": float(np.sqrt(np.mean(u**2))),
        "largest_deviation_95_arcsec": float(np.quantile(np.abs(off).max(axis=1), COVERAGE)),
    }
