"""How probable each effect, none of them, and something unknown are, given the set.

Each effect's evidence is the marginal likelihood of its block of columns under a prior that tells
as much as one row does (unit information: Kass and Raftery, J. Am. Stat. Assoc. 90 (1995) 773),
from the likelihood ratio with the noise free on both sides. Each place that its search looked at
shares the prior evenly. What the rules of the verdict exclude is bounded by the odds of the rule.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri, logsumexp

from arctrue.workbench.inference.significance import single_p_value

NONE, UNKNOWN = "none", "unknown"
PRIOR_NONE = 0.5
"""Nothing is missing: as probable beforehand as that something is."""
PRIOR_CATALOGUE = 0.4
"""An effect of the catalogue is missing; shared evenly among its effects."""
PRIOR_PRODUCT = 0.09
"""A product of parts that no catalogue has."""
PRIOR_STRANGER = 0.01
"""Something that no product of parts describes."""


@dataclass(frozen=True)
class Weighed:
    """What a likelihood ratio says of one effect, or of one product of parts."""

    gain: float
    """Twice the rise of the log likelihood."""
    rank: int
    trials: float
    """Places that share its prior."""
    rows: int
    """From which its size is known: those of the channels that it moves."""
    freedom: float = float("inf")
    """Degrees of freedom with which the noise of its size is known: so many of the rows are
    independent (ten, of 24,000, where four runs tell)."""


def log_evidence(item: Weighed) -> float:
    """Log of the Bayes factor against the model without it.

    With coefficients b ~ N(0, n·(XᵀC⁻¹X)⁻¹), n the rows, it is
    −(q/2)·log(1 + n) + (gain/2)·n/(1 + n), the prior shared by the places.
    """
    if item.rank == 0:
        return 0.0
    rows = float(max(min(item.rows, item.freedom), 1))
    gain = _with_known_noise(item)
    log_factor = -0.5 * item.rank * np.log1p(rows) + 0.5 * gain * rows / (1.0 + rows)
    return float(log_factor - np.log(max(item.trials, 1.0)))


def _with_known_noise(item: Weighed) -> float:
    """The gain that would be as rare with noise that is known as this one is with its own."""
    p_value = single_p_value(item.gain, item.rank, item.freedom)
    if not np.isfinite(item.freedom) or p_value < 1e-290:
        return item.gain
    return min(item.gain, float(chdtri(item.rank, p_value)))


def log_evidence_of_p(p_value: float) -> float:
    """Largest log Bayes factor that a p value can stand for: −log(−e·p·log p).

    Sellke, Bayarri and Berger, Am. Stat. 55 (2001) 62; 0 for p above 1/e.
    """
    if p_value >= np.exp(-1.0):
        return 0.0
    p_value = max(p_value, 1e-300)
    return float(-np.log(-np.e * p_value * np.log(p_value)))


def prior(effects: int) -> float:
    """Of each one of so many effects of the catalogue."""
    return PRIOR_CATALOGUE / max(effects, 1)


def normalised(log_weights: Mapping[str, float]) -> dict[str, float]:
    """Probabilities with a sum of 1 from logarithms of weights."""
    values = np.array(list(log_weights.values()))
    shares = np.exp(values - logsumexp(values))
    return dict(zip(log_weights, (shares / shares.sum()).tolist(), strict=True))


def untold(tested: int, untested: int) -> dict[str, float]:
    """Weights before the set: what it cannot tell, nothing of it changes.

    Effects that it cannot test are unknown.
    """
    share = PRIOR_CATALOGUE * untested / max(tested + untested, 1)
    return {
        NONE: float(np.log(PRIOR_NONE)),
        UNKNOWN: float(np.log(PRIOR_PRODUCT + PRIOR_STRANGER + share)),
    }
