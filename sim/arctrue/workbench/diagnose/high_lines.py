"""Finds lines of the capture at whole and half orders above the orders of products of parts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.disc import DISC_BINS
from arctrue.workbench.noise.row_noise import RowNoise

Float = NDArray[np.float64]

HIGHEST = DISC_BINS / 8.0
"""Highest order of the search; bins reduce the amplitude of a wave of this order by 5 %."""
SURE_P = 1e-4
"""Largest p of a line, corrected for the number of orders: the limit of a sure lack of fit. It also
limits the false alarms of all products with a high order."""
MOST_LINES = 3
"""Largest number of lines, to limit cost; it equals the number of effects that a diagnosis tests
one after another."""
APART = 1.0
"""Smallest distance of two lines; a half order leaks into its neighbours."""


def high_lines(residuals: Residuals, above: float) -> tuple[list[float], int]:
    """Return the orders of the strongest sure lines, and the number of orders that were searched.

    Each run has its own amplitude and phase, so that a line is found with any condition as its
    factor. Orders of half the samples per turn and more are left out.
    """
    rows, noise = residuals.observations.capture, residuals.solution.noise.capture
    precise = residuals.capture_precise
    if rows is None or noise is None or precise is None:
        return [], 0
    parts = [part for part in noise.stretches if part.stop - part.start > 2]
    ways = [float(np.median(np.abs(np.diff(rows.angle_rad[part])))) for part in parts]
    # A slow run may have most rows at one place: a median step of 0 does not limit the orders.
    highest = min([HIGHEST, *(np.pi / way for way in ways if way > 0.0)])
    halves = np.arange(int(2.0 * above) + 1, int(np.ceil(2.0 * highest)))
    orders: Float = 0.5 * halves.astype(np.float64)
    if not parts or halves.size == 0:
        return [], 0
    gains = np.zeros(halves.size)
    for part in parts:
        place = np.mod(0.5 * rows.angle_rad[part] / (2.0 * np.pi), 1.0) * 2 * DISC_BINS
        # Each row is divided between two bins, because rounding to one bin would add sidebands to a
        # strong line.
        low = np.floor(place).astype(np.int64)
        upper, values = place - low, precise[part]
        sums = np.bincount(low, (1.0 - upper) * values, 2 * DISC_BINS + 1)
        sums += np.bincount(low + 1, upper * values, 2 * DISC_BINS + 1)
        sums[0] += sums[-1]
        sums = sums[:-1]
        information = _information(noise, part, rows.angle_rad, orders)
        gains += 2.0 * np.abs(np.fft.rfft(sums)[halves]) ** 2 / information
    p_values = halves.size * chdtrc(2.0 * len(parts), gains)
    found: list[float] = []
    for index in np.argsort(-gains):
        if len(found) == MOST_LINES or p_values[index] >= SURE_P:
            break
        order = float(orders[index])
        if all(abs(order - other) > APART for other in found):
            found.append(order)
    return found, int(halves.size)


def _information(noise: RowNoise, part: slice, angle_rad: Float, orders: Float) -> Float:
    """Return the number of rows of a stretch divided by the noise density at each order."""
    spectrum = noise.spectra[noise.stretches.index(part)]
    step_s = noise.step(part)
    way = float(np.median(np.abs(np.diff(angle_rad[part])))) / (2.0 * np.pi)
    density = spectrum.density(orders * (way / max(step_s, 1e-300)), step_s)
    return np.asarray((part.stop - part.start) / (density * noise.mean_square_scale(part)))


def gains_with(residuals: Residuals, factors: Sequence[Float], order: float) -> Float:
    """Return the approximate gain of each condition, (conditions,), times a wave of this order."""
    rows, noise = residuals.observations.capture, residuals.solution.noise.capture
    precise = residuals.capture_precise
    assert rows is not None
    assert noise is not None
    assert precise is not None
    wave = np.exp(1j * order * rows.angle_rad)
    channels = (
        [rows.channel == n for n in range(rows.channels)]
        if rows.channel is not None
        else [np.ones(precise.size, dtype=np.bool_)]
    )
    found = []
    for factor in factors:
        power = sum(abs(np.sum((factor * precise * wave)[inside])) ** 2 for inside in channels)
        information = 1e-30
        for part in noise.stretches:
            if part.stop - part.start > 2:
                weight = float(np.mean(factor[part] ** 2))
                own = _information(noise, part, rows.angle_rad, np.array([order]))
                information += weight * float(own[0])
        found.append(2.0 * len(channels) * float(power) / information)
    return np.array(found)
