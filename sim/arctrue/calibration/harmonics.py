"""Sums harmonics, and converts a function of the true angle to a function of the reading."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

_BLOCK = 1 << 15


def unit_vectors(counts: Integer, counts_per_rev: int) -> NDArray[np.complex128]:
    """Return e^{jR} for readings in counts, (n,); the counts are first reduced to one turn as
    integers."""
    return np.exp((2j * np.pi / counts_per_rev) * np.remainder(counts, counts_per_rev))


def powers(vectors: NDArray[np.complex128], orders: Integer) -> NDArray[np.complex128]:
    """Return ``vectors``ⁿ for every order, (n, orders)."""
    # An order's column is contiguous in memory: it is written and read as a whole.
    result = np.empty((vectors.size, orders.size), dtype=np.complex128, order="F")
    if orders.size and np.array_equal(orders, np.arange(1, orders.size + 1)):
        # One multiplication per order is faster than a power, which needs a logarithm.
        running = vectors
        for index in range(orders.size):
            result[:, index] = running
            running = running * vectors
        return result
    return np.power(vectors[:, None], orders[None, :])


def error_arcsec(orders: Integer, values: Float, x_rad: Float) -> Float:
    """Return Σ cosine·cos(n·x) + sine·sin(n·x); ``values``: (2·orders,), ``x_rad``: any shape."""
    x = np.asarray(x_rad, dtype=np.float64)
    flat = x.ravel()
    cosine, sine = np.split(np.asarray(values), 2)
    result = np.empty(flat.size)
    for start in range(0, flat.size, _BLOCK):
        part = flat[start : start + _BLOCK]
        vectors = powers(np.exp(1j * part), orders)
        result[start : start + part.size] = vectors.real @ cosine + vectors.imag @ sine
    return result.reshape(x.shape)


def as_function_of_reading(orders: Integer, values: Float) -> Float:
    """Convert the harmonics of ε to the harmonics of g with g(R) = ε(θ), R = θ + ε(θ); arcseconds,
    (2·orders,).

    The gateware calculates ε at the reading, equation (8). With ε(R) in place of ε(θ) an error of
    ε·ε′ would remain (0.055″ at order 2 for an eccentricity of 150″); with g no such error remains.
    """
    most = int(orders.max(initial=1))
    number = 1 << max(10, int(np.ceil(np.log2(16 * most))))
    reading = np.linspace(0.0, 2.0 * np.pi, number, endpoint=False)
    g = error_arcsec(orders, values, reading)
    for _ in range(20):
        before = g
        g = error_arcsec(orders, values, reading - g * RAD_PER_ARCSEC)
        if np.max(np.abs(g - before)) < 1e-10:
            break
    spectrum = np.fft.rfft(g) * (2.0 / number)
    return np.concatenate((spectrum.real[orders], -spectrum.imag[orders]))
