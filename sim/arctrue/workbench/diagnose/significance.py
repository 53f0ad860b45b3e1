"""From a gain in χ² to a probability that counts every place that was looked at."""

from __future__ import annotations

import numpy as np
from scipy.stats import chi2


def corrected_p_value(
    gain: float, rank: int, trials: float, candidates: int, inflation: float = 1.0
) -> float:
    """Probability of such a gain, or more, by chance somewhere among all that was tried.

    ``gain`` is χ² with ``rank`` degrees of freedom at the best of ``trials`` independent places,
    for one of ``candidates`` effects; ``inflation`` ≥ 1 is the noise's excess over white noise,
    from surrogates. Šidák over places, Bonferroni over candidates.
    """
    if rank <= 0:
        return 1.0
    log_single = float(chi2.logsf(gain / max(inflation, 1.0), rank))
    single = np.exp(log_single)
    # 1 − (1 − p)^m without loss for small p; for tiny p it is m·p.
    placed = float(-np.expm1(max(trials, 1.0) * np.log1p(-min(single, 1.0 - 1e-15))))
    return float(min(1.0, max(placed, 0.0) * max(candidates, 1)))
