"""Estimates the noise at each order from the residual of the fit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from arctrue.calibration.capture_check import WholeTurns

Float = NDArray[np.float64]

NEIGHBOURS = 96
"""Number of lines of the residual's spectrum whose mean power is the noise at an order. The
uncertainty is the root of this mean; its relative standard deviation is 1/(2·√96) = 5 %."""
PEAK_FALSE_ALARM = 1e-4
"""Chosen probability that white noise alone has a line that counts as a peak."""


class ResidualSpectrum:
    """Periodogram of the residuals of all runs as a function of the order; white noise of variance
    1 gives 1.

    ``residuals``: one array per run, each divided by the standard deviation of its run's noise;
    ``sigmas``: these standard deviations.
    Lines of the fitted orders are omitted, because the fit has removed them.
    """

    def __init__(
        self,
        turns: Sequence[WholeTurns],
        residuals: Sequence[Float],
        sigmas: Float,
        fitted: NDArray[np.int64],
    ) -> None:
        """Calculate one periodogram for each run; the lines of all runs are in one list."""
        orders, power, amplitude = [], [], []
        for part, residual, sigma in zip(turns, residuals, sigmas, strict=True):
            spectrum = np.fft.rfft(residual)[1 : (residual.size + 1) // 2]
            line = np.arange(1, spectrum.size + 1)
            whole = (line % part.turns == 0) & np.isin(line // part.turns, fitted)
            free = ~whole
            orders.append(line[free] / part.turns)
            power.append(np.abs(spectrum[free]) ** 2 / residual.size)
            amplitude.append(np.abs(spectrum[free]) * (2.0 / residual.size) * sigma)
        joined = np.concatenate(orders)
        sorting = np.argsort(joined, kind="stable")
        self.orders: Float = joined[sorting]
        self.power: Float = np.concatenate(power)[sorting]
        self.amplitude: Float = np.concatenate(amplitude)[sorting]

    def at(self, orders: NDArray[np.int64]) -> Float:
        """Return the power near each order: the mean over its nearest lines, (orders,)."""
        total = np.concatenate(([0.0], np.cumsum(self.power)))
        number = min(NEIGHBOURS, self.power.size)
        if number == 0:
            return np.ones(orders.size)
        first = np.searchsorted(self.orders, orders) - number // 2
        # Near order 0 there are no lower lines; the mean then uses more lines above the order.
        first = np.clip(first, 0, self.power.size - number)
        return np.asarray((total[first + number] - total[first]) / number)

    def peaks(self, most: int = 3) -> list[tuple[float, float]]:
        """Return the largest spectral lines that white noise does not explain, at most ``most``:
        (order, amplitude in the unit of the residuals' standard deviations)."""
        if self.power.size < NEIGHBOURS:
            return []
        # The median of an exponential distribution is ln 2 times its mean, and a few strong lines
        # hardly change it.
        floor = float(np.median(self.power)) / np.log(2.0)
        limit = floor * np.log(self.power.size / PEAK_FALSE_ALARM)
        found: list[tuple[float, float]] = []
        for index in np.argsort(self.power)[::-1]:
            if self.power[index] < limit or len(found) == most:
                break
            order = float(self.orders[index])
            # The neighbours of a found line belong to it and are not lines of their own.
            if all(abs(order - other) > 1.5 for other, _ in found):
                found.append((order, float(self.amplitude[index])))
        return found
