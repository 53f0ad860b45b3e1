"""Converts a likelihood ratio to a p value that is corrected for the number of values that a search
tried."""

from __future__ import annotations

import numpy as np
from scipy.special import chdtrc, chdtri, fdtrc, gammaln

SIGNIFICANCE = 0.01
"""Largest corrected p with which an effect is named: in 1 % of sets with an adequate model, an
effect is named falsely."""
MANY = 1e5
"""If there are more degrees of freedom than this, the noise variance counts as known."""
TRIALS_ROUNDS = 4
"""Number of rounds in which gain and trials follow from each other; each round divides the error of
the trials by about the gain, 20 or more."""


def single_p_value(gain: float, rank: int, freedom: float) -> float:
    """Return the probability that chance gives a gain at least as large, for one set of search
    parameters.

    ``gain`` is twice the rise of the log likelihood by ``rank`` columns, where each model has its
    own best noise; ``freedom`` is the number of degrees of freedom of the noise variance after the
    columns are fitted. In white noise this is the F test: with m degrees of freedom left, the rise
    is (m + q)·log(1 + q·F/m). Kenward and Roger, Biometrics 53 (1997) 983, give m for other noise.
    """
    if rank <= 0:
        return 1.0
    if freedom > MANY:
        return float(chdtrc(rank, gain))
    ratio = freedom / rank * float(np.expm1(min(gain / (freedom + rank), 600.0)))
    return float(fdtrc(rank, freedom, ratio))


def corrected_p_value(
    gain: float, rank: int, trials: float, candidates: int, freedom: float = np.inf
) -> float:
    """Return the probability that chance gives a gain at least as large anywhere in the search.

    The gain belongs to the best of ``trials`` independent sets of search parameters, for one of
    ``candidates`` effects. The correction is by Šidák for the trials and by Bonferroni for the
    candidates.
    """
    single = single_p_value(gain, rank, freedom)
    # This gives 1 − (1 − p)^m without rounding loss for small p; for tiny p it is m·p.
    placed = float(-np.expm1(max(trials, 1.0) * np.log1p(-min(single, 1.0 - 1e-15))))
    return float(min(1.0, max(placed, 0.0) * max(candidates, 1)))


def trials_of_a_line(periods: float, rank: int) -> float:
    """Return the number of independent rates in the search for a line over a continuous range.

    ``periods``: range of the rates times the length of the record, B·T. In white noise the gain at
    each rate is χ² with ``rank`` degrees of freedom. The mean number of places at which the gain
    rises above u is B·T·√(π/3)·(u/2)^((rank − 1)/2)·e^(−u/2)/Γ(rank/2) for evenly spaced rows
    (Davies, Biometrika 74 (1987) 33; Baluev, Mon. Not. R. Astron. Soc. 385 (2008) 1279). Divided by
    the probability at one rate, this is a number of trials that grows slowly with u, for rank 2 as
    √(u/2). The result is the number at the gain that chance exceeds with the probability
    SIGNIFICANCE: 3 to 4 times B·T, because the maximum may be between two of the 2·B·T rates.
    """
    trials = max(2.0 * periods, 1.0)
    for _ in range(TRIALS_ROUNDS):
        gain = float(chdtri(rank, SIGNIFICANCE / trials))
        rising = 0.5 * (rank - 1) * np.log(0.5 * gain) - 0.5 * gain - float(gammaln(0.5 * rank))
        crossings = periods * np.sqrt(np.pi / 3.0) * float(np.exp(rising))
        trials = 1.0 + crossings / float(chdtrc(rank, gain))
    return float(trials)
