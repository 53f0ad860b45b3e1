"""Models the entity ``parity_sum`` and computes its weights. The parity is a sum Σ cᵢ·rᵢ of the
heads' readings, which neither the rotation nor a motion of the axis changes."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.gateware.mean_set import WEIGHT_ONE
from arctrue.generated.number_formats import CORRECTION_FRACTION, MEAN_TERM_FRACTION

PARITY_LSB_COUNTS: Final = 2.0**-CORRECTION_FRACTION
"""Value of the last bit of a word of the parity, counts."""


def parity_sum(differences: ArrayLike, weights: ArrayLike) -> NDArray[np.int64]:
    """Return the parity in 2⁻¹¹ count, rounded down: (clocks,).

    ``differences`` (clocks, heads) in 1/16 count, ``weights`` (heads,) in 2⁻¹⁶.
    """
    products = np.asarray(differences, dtype=np.int64) * np.asarray(weights, dtype=np.int64)
    parity: NDArray[np.int64] = products.sum(axis=-1) >> MEAN_TERM_FRACTION - CORRECTION_FRACTION
    return parity


def parity_weights(places_rad: ArrayLike) -> NDArray[np.int64]:
    """Compute the words cᵢ for four heads at ``places_rad``: Σ cᵢ = 0, Σ cᵢ·e^{jβᵢ} = 0, max |cᵢ| =
    1.

    Three real equations for four weights have one solution up to a factor; here c₁ > 0. The
    rounding of the words to 2⁻¹⁶ keeps Σ cᵢ = 0 exact. Raises ValueError for another number of
    heads; for three heads no such sum exists.
    """
    places = np.asarray(places_rad, dtype=np.float64)
    if places.shape != (4,):
        raise ValueError(f"parity: expected four heads, found {places.size}; three have no parity")
    rows = np.array([np.ones(4), np.cos(places), np.sin(places)])
    direction = np.linalg.svd(rows)[2][-1]
    direction = direction / np.abs(direction).max() * np.sign(direction[0])
    words: NDArray[np.int64] = np.rint(direction * WEIGHT_ONE).astype(np.int64)
    words[int(np.argmax(np.abs(words)))] -= words.sum()
    return words
