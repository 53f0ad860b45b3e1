"""Selects the orders that the gateware is to apply, and states why other orders are left out."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from arctrue.calibration.estimate import Estimate
from arctrue.calibration.noise import NEIGHBOURS

FALSE_ALARM = 0.05
"""Probability that noise alone makes at least one order of a set significant."""
GAIN_LIMIT_DEFAULT = 50.0
"""Largest noise gain of an order. With heads 33° apart this limit keeps n = 11 and 109 (gain 19)
and excludes the multiples of 120."""
UNCERTAINTY_LIMIT_ARCSEC = 0.1
"""Standard uncertainty above which an order is flagged."""


@dataclass(frozen=True)
class Verdict:
    """Decision on one order. ``reason`` states why it is not applied; ``flags`` are further remarks
    for the user."""

    order: int
    applied: bool
    reason: str
    flags: tuple[str, ...]


def significance_factor(orders: int) -> float:
    """Return the ratio of amplitude to standard uncertainty that noise exceeds at one order or more
    with a probability of 5 %.

    A²/2u² of noise has an F distribution with (2, 2m) degrees of freedom, since u is estimated from
    m lines of the spectrum: P(A > k·u) = (1 + k²/2m)⁻ᵐ, which for many lines is the Rayleigh
    distribution.
    """
    chance = FALSE_ALARM / max(orders, 1)
    return math.sqrt(2.0 * NEIGHBOURS * math.expm1(-math.log(chance) / NEIGHBOURS))


def select_orders(
    estimate: Estimate,
    lanes: int,
    gain_limit: float = GAIN_LIMIT_DEFAULT,
    uncertainty_limit_arcsec: float = UNCERTAINTY_LIMIT_ARCSEC,
) -> tuple[Verdict, ...]:
    """Return one verdict per order. An order is applied if the heads determine it, it is
    significant, its gain is within the limit, and a lane is free.

    If there are fewer lanes than such orders, the orders with the largest amplitudes get the lanes.
    """
    amplitude = estimate.amplitude_arcsec
    u = estimate.u_component_arcsec
    seen = np.isfinite(estimate.noise_gain)
    quiet = estimate.noise_gain <= gain_limit
    factor = significance_factor(int(np.count_nonzero(seen)))
    significant = amplitude > factor * u
    wanted = seen & quiet & significant
    by_size = np.argsort(np.where(wanted, -amplitude, np.inf), kind="stable")
    kept = np.zeros(wanted.size, dtype=bool)
    kept[by_size[:lanes]] = True
    applied = wanted & kept

    verdicts = []
    for i, order in enumerate(estimate.orders.tolist()):
        flags = []
        if seen[i] and u[i] > uncertainty_limit_arcsec:
            flags.append(f"uncertainty above {uncertainty_limit_arcsec:g}″")
        if estimate.disagreement[i] > 1.0:
            flags.append("runs disagree")
        if not seen[i]:
            reason = "cannot be seen: n·α is a whole number of turns"
        elif not quiet[i]:
            reason = f"noise gain above {gain_limit:g}"
        elif not significant[i]:
            reason = f"not significant: below {factor:.1f} u"
        elif not kept[i]:
            reason = f"no lane free: {lanes} larger orders"
        else:
            reason = ""
        verdicts.append(Verdict(order, bool(applied[i]), reason, tuple(flags)))
    return tuple(verdicts)
