"""Calculates the weights of independent differences of the readings of any number of heads.

The differences Rᵢ − R₁ all contain the noise of head 1. If the heads have independent noise of
equal σ, the covariance of the differences is σ²(I + 1·1ᵀ). The inverse of its Cholesky factor,
times √2·σ, turns the differences into

    dₖ = √(2(k − 1)/k)·(Rₖ − (R₁ + … + Rₖ₋₁)/(k − 1)),  k = 2 … H,

the Helmert contrasts, which are independent and each have the noise of R₂ − R₁; d₂ is R₂ − R₁.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]


def contrast_weights(heads: int) -> Float:
    """Return the weights of the differences Rᵢ − R₁, i = 2 … H, in each contrast; shape (H − 1
    contrasts, H − 1 differences)."""
    weights = np.zeros((heads - 1, heads - 1))
    for channel in range(heads - 1):
        head = channel + 2
        weights[channel, :channel] = -1.0 / (head - 1)
        weights[channel, channel] = 1.0
        weights[channel] *= np.sqrt(2.0 * (head - 1) / head)
    return weights
