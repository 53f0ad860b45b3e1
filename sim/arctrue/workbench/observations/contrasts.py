"""Calculates the weights of independent differences of the readings of any number of heads.

The differences Rᵢ − R₁ all contain the noise of head 1. If the heads have independent noise of
equal σ, the covariance of the differences is σ²(I + 1·1ᵀ). The inverse of its Cholesky factor,
times √2·σ, turns the differences into

    dₖ = √(2(k − 1)/k)·(Rₖ − (R₁ + … + Rₖ₋₁)/(k − 1)),  k = 2 … H,

the Helmert contrasts, which are independent and each have the noise of R₂ − R₁; d₂ is R₂ − R₁.
If the heads have unequal noise, the inverse Cholesky factor of the measured covariance replaces
this one: the heads before head k then have weights that fall with their noise.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]


def contrast_weights(heads: int, covariance: Float | None = None) -> Float:
    """Return the weights of the differences Rᵢ − R₁, i = 2 … H, in each contrast; shape (H − 1
    contrasts, H − 1 differences).

    ``covariance``: covariance of the differences, if the heads have unequal noise. Each contrast is
    scaled so that independent errors of equal size in all heads, such as those of the index, have
    the same variance as in R₂ − R₁.
    """
    if covariance is not None:
        weights = np.linalg.inv(np.linalg.cholesky(covariance))
        squares = np.sum(weights**2, axis=1) + np.sum(weights, axis=1) ** 2
        return np.asarray(weights * np.sqrt(2.0 / squares)[:, np.newaxis])
    weights = np.zeros((heads - 1, heads - 1))
    for channel in range(heads - 1):
        head = channel + 2
        weights[channel, :channel] = -1.0 / (head - 1)
        weights[channel, channel] = 1.0
        weights[channel] *= np.sqrt(2.0 * (head - 1) / head)
    return weights


def offset_weights(heads: int, covariance: Float) -> Float:
    """Return the weights of the Helmert contrasts in each contrast, shape (H − 1, H − 1).

    The indexes of all heads repeat equally well, so that the offsets of a run are independent in
    the Helmert contrasts, also if the heads have unequal noise.
    """
    return np.asarray(contrast_weights(heads, covariance) @ np.linalg.inv(contrast_weights(heads)))
