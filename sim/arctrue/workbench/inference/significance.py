"""Converts a likelihood ratio to a p value that is corrected for the number of values that a search
tried."""

from __future__ import annotations

import numpy as np
from scipy.special import chdtrc, fdtrc

SIGNIFICANCE = 0.01
"""Largest corrected p with which an effect is named: in 1 % of sets with an adequate model, an
effect is named falsely."""
MANY = 1e5
"""If there are more degrees of freedom than this, the noise variance counts as known."""


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
