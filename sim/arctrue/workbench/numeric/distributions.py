"""Calculates probabilities of Student's t and of F with :mod:`scipy.special`.

``scipy.stats`` has the same functions, but its import takes a large part of the start of a command
(``python -X importtime -c "import scipy.stats"``).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import betaincinv, gammaln, ndtr, ndtri, stdtr, stdtrit

Float = NDArray[np.float64]


def student_upper_p(value: float, freedom: float) -> float:
    """Return the probability that Student's t exceeds ``value``; the normal distribution for
    infinite degrees of freedom."""
    return float(ndtr(-value) if np.isinf(freedom) else stdtr(freedom, -value))


def student_quantile(p: float, freedom: float) -> float:
    """Return the value below which Student's t lies with the probability ``p``; the normal
    distribution for infinite degrees of freedom."""
    return float(ndtri(p) if np.isinf(freedom) else stdtrit(freedom, p))


def student_limit(p: float, freedom: float) -> float:
    """Return the value that Student's t exceeds with the probability ``p``; precise for small
    ``p``."""
    return -student_quantile(p, freedom)


def student_log_density(values: Float, freedom: float) -> Float:
    """Return the logarithm of the density of Student's t at each value."""
    constant = (
        gammaln(0.5 * (freedom + 1.0)) - gammaln(0.5 * freedom) - 0.5 * np.log(np.pi * freedom)
    )
    return np.asarray(constant - 0.5 * (freedom + 1.0) * np.log1p(values**2 / freedom))


def f_limit(p: float, above: float, below: float) -> float:
    """Return the value that F with ``above`` and ``below`` degrees of freedom exceeds with the
    probability ``p``; precise for small ``p``.

    P(F > x) is the regularised incomplete beta function I(b/2, a/2) at b/(b + a·x).
    """
    place = float(betaincinv(0.5 * below, 0.5 * above, p))
    return below * (1.0 / place - 1.0) / above
