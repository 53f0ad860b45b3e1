"""Calculates the degrees of freedom of the noise in a linear combination of rows."""

from __future__ import annotations

import numpy as np
from celerite2 import driver  # type: ignore[import-untyped]
from numpy.typing import NDArray

from arctrue.workbench.noise.noise import Noise
from arctrue.workbench.noise.row_noise import RowNoise

Float = NDArray[np.float64]

LEAST_FREEDOM = 2.0
"""Smallest number of degrees of freedom m that is returned; below it the mean of 1/χ² is infinite.
"""


def degrees_of_freedom(
    noise: Noise,
    weights: tuple[Float | None, Float | None],
    offsets: Float,
    runs: dict[str, NDArray[np.int64]],
) -> tuple[float, float]:
    """Return the degrees of freedom of the noise, and the index's share of the variance.

    ``weights`` is C⁻¹z of each channel, where z is the sum of the projected columns times their
    coefficients; ``offsets`` is the part of these columns that the offsets of the runs absorb. The
    covariance is C = Σ θⱼ·Cⱼ, with the variance θⱼ of each part of the noise. The variance of the
    estimate has the logarithmic derivatives hⱼ = θⱼ·uᵀCⱼu/zᵀC⁻¹z, with u = C⁻¹z.
    With the covariance of the logarithms of the θⱼ, they give the variance of the logarithm of the
    variance, 2/m (Satterthwaite, Biometrics 2 (1946) 110).
    """
    parts: list[tuple[Float, Float]] = []
    total = 0.0
    for group in noise.groups:
        of_rows = noise.capture if group.channel == "capture" else noise.reference
        weight = weights[0] if group.channel == "capture" else weights[1]
        if of_rows is None or weight is None or of_rows.weightless:
            continue
        shares = _shares(of_rows, weight, runs[group.channel], group.runs)
        parts.append((shares, group.fit.covariance))
        total += float(shares.sum())
    fitted = {group.channel for group in noise.groups}
    for channel, weight in zip(("capture", "reference"), weights, strict=True):
        # Noise that was given, not estimated, counts as exactly known.
        if channel in fitted or weight is None:
            continue
        of_rows = noise.capture if channel == "capture" else noise.reference
        if of_rows is not None:
            names = tuple(np.unique(runs[channel]).tolist())
            total += float(_shares(of_rows, weight, runs[channel], names).sum())
    index = float(offsets @ offsets) / noise.index_variance
    total += index
    if total <= 0.0:
        return LEAST_FREEDOM, 0.0
    spread = sum(float(shares @ covariance @ shares) for shares, covariance in parts) / total**2
    known = noise.index_freedom + offsets.size
    if offsets.size:
        spread += (index / total) ** 2 * 2.0 / known
    return max(2.0 / max(spread, 1e-12), LEAST_FREEDOM), index / total


def _shares(
    noise: RowNoise, weight: Float, run: NDArray[np.int64], members: tuple[int, ...]
) -> Float:
    """Return θⱼ·uᵀCⱼu of the white part and of each coloured part."""
    found: Float | None = None
    for rows, spectrum in zip(noise.stretches, noise.spectra, strict=True):
        if int(run[rows.start]) not in members:
            continue
        scaled = weight[rows] * noise.scale[rows]
        own = np.empty(1 + spectrum.constants.size)
        own[0] = spectrum.white * float(scaled @ scaled)
        clock = np.ascontiguousarray(noise.clock[rows])
        column = np.ascontiguousarray(scaled[:, np.newaxis])
        ones = np.ones((clock.size, 1))
        for index, constant in enumerate(spectrum.constants):
            rate = np.array([1.0 / constant])
            below = driver.matmul_lower(clock, rate, ones, ones, column, np.zeros_like(column))
            # K is the unit matrix plus a lower and an upper triangle; both triangles contribute
            # equally to uᵀKu.
            product = float(scaled @ scaled) + 2.0 * float(scaled @ below[:, 0])
            own[1 + index] = spectrum.variances[index] * product
        found = own if found is None else found + own
    return np.zeros(1) if found is None else found
