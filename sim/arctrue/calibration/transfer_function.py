"""Calculates the transfer function of two read heads, equation (6)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

UNSEEN_GAIN = 1e4
"""Limit of |TF|: an order with a smaller |TF| is seen, which means that the difference of the heads
determines it. Above this limit |e^{jnα} − 1| is smaller than the uncertainty of α and counts as 0.
"""


def transfer_function(orders: ArrayLike, head_separation_rad: float) -> NDArray[np.complex128]:
    """Return TF(n) = 1/(e^{jnα} − 1), shaped like ``orders``; 0 for an order that is not
    determined."""
    phase = np.asarray(orders, dtype=np.float64) * head_separation_rad
    # e^{jx} − 1 = 2j·sin(x/2)·e^{jx/2} keeps its digits near x = 0 and whole turns.
    denominator = 2j * np.sin(phase / 2.0) * np.exp(0.5j * phase)
    seen = np.abs(denominator) > 1.0 / UNSEEN_GAIN
    transfer: NDArray[np.complex128] = np.zeros(phase.shape, dtype=np.complex128)
    np.divide(1.0, denominator, out=transfer, where=seen)
    return transfer


def separation_slope(
    orders: NDArray[np.int64], values: NDArray[np.float64], head_separation_rad: float
) -> NDArray[np.complex128]:
    """Return dE_n/dα = −j·n·e^{jnα}·TF(n)·E_n, arcseconds per radian: the effect of an error of α.

    ``values``: (2·orders,) in arcseconds, cosines before sines; E_n here is cosine − j·sine.
    """
    cosine, sine = np.split(values, 2)
    turned = np.exp(1j * orders * head_separation_rad)
    gain = transfer_function(orders, head_separation_rad)
    return np.asarray(-1j * orders * turned * gain * (cosine - 1j * sine))


def noise_gain(orders: ArrayLike, head_separation_rad: float) -> NDArray[np.float64]:
    """Return |TF(n)|, the ratio of the noise of ε to the noise of δ₂₁, for each order; infinite for
    an order that the heads do not determine."""
    gain = np.abs(transfer_function(orders, head_separation_rad))
    return np.where(gain > 0.0, gain, np.inf)
