"""Calculates the probability of each effect, of no missing effect, and of an unknown effect, given
the set.

The evidence of an effect is the marginal likelihood of its block of columns under a prior with the
information of one row (unit information: Kass and Raftery, J. Am. Stat. Assoc. 90 (1995) 773); it
follows from the likelihood ratio, where each model has its own noise estimate. The values of the
search parameters that a search tried share the prior evenly. The odds of a rule bound the
probability of the hypotheses that the rule excludes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtri, logsumexp

from arctrue.workbench.inference.significance import single_p_value

NONE, UNKNOWN = "none", "unknown"
PRIOR_NONE = 0.5
"""Prior probability that no effect is missing. It equals the probability that an effect is
missing."""
PRIOR_CATALOGUE = 0.4
"""Prior probability that an effect of the catalogue is missing; the effects of the catalogue share
it evenly."""
PRIOR_PRODUCT = 0.09
"""Prior probability of a product of parts that is in no catalogue."""
PRIOR_STRANGER = 0.01
"""Prior probability of an effect that no product of parts describes."""


@dataclass(frozen=True)
class Weighed:
    """Likelihood ratio of one effect or product of parts, and the numbers for its evidence."""

    gain: float
    """Twice the rise of the log likelihood."""
    rank: int
    trials: float
    """Number of independent values of the search parameters, which share the effect's prior."""
    rows: int
    """Number of rows that determine the effect's size: the rows of the channels that the effect
    changes."""
    freedom: float = float("inf")
    """Degrees of freedom of the noise variance; few if the runs, not the rows, are the sample (for
    example ten for four runs, which have 24,000 rows together)."""


def log_evidence(item: Weighed) -> float:
    """Return the log of the Bayes factor against the model without the effect.

    With coefficients b ~ N(0, n·(XᵀC⁻¹X)⁻¹) and n rows the result is −(q/2)·log(1 + n) +
    (gain/2)·n/(1 + n), minus the log of the number of trials, which share the prior.
    """
    if item.rank == 0:
        return 0.0
    rows = float(max(min(item.rows, item.freedom), 1))
    gain = _with_known_noise(item)
    log_factor = -0.5 * item.rank * np.log1p(rows) + 0.5 * gain * rows / (1.0 + rows)
    return float(log_factor - np.log(max(item.trials, 1.0)))


def _with_known_noise(item: Weighed) -> float:
    """Return the gain that has the same p with known noise as this gain has with its estimated
    noise."""
    p_value = single_p_value(item.gain, item.rank, item.freedom)
    if not np.isfinite(item.freedom) or p_value < 1e-290:
        return item.gain
    return min(item.gain, float(chdtri(item.rank, p_value)))


def log_evidence_of_p(p_value: float) -> float:
    """Return the largest log Bayes factor that a p value can give: −log(−e·p·log p), or 0 for p
    above 1/e.

    Sellke, Bayarri and Berger, Am. Stat. 55 (2001) 62.
    """
    if p_value >= np.exp(-1.0):
        return 0.0
    p_value = max(p_value, 1e-300)
    return float(-np.log(-np.e * p_value * np.log(p_value)))


def prior(effects: int) -> float:
    """Return the prior probability of each effect of a catalogue with ``effects`` effects."""
    return PRIOR_CATALOGUE / max(effects, 1)


def normalised(log_weights: Mapping[str, float]) -> dict[str, float]:
    """Return probabilities with a sum of 1 from logarithms of weights."""
    values = np.array(list(log_weights.values()))
    shares = np.exp(values - logsumexp(values))
    return dict(zip(log_weights, (shares / shares.sum()).tolist(), strict=True))


def prior_weights(tested: int, untested: int) -> dict[str, float]:
    """Return the logarithms of the prior weights of ``none`` and ``unknown``, for a verdict without
    evidence.

    Effects that the set cannot test count as unknown.
    """
    share = PRIOR_CATALOGUE * untested / max(tested + untested, 1)
    return {
        NONE: float(np.log(PRIOR_NONE)),
        UNKNOWN: float(np.log(PRIOR_PRODUCT + PRIOR_STRANGER + share)),
    }
