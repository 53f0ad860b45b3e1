"""Draws the autocorrelation of whitened residuals, and their quantiles over those of the normal
distribution."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from arctrue.report.charts.chart import (
    CHANNEL_COLOUR,
    QUIET,
    Axis,
    Band,
    Bars,
    Chart,
    Curve,
    Layer,
    Panel,
)
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.noise.whiteness import LAGS, LEAST_ROWS, autocorrelations

Float = NDArray[np.float64]

WITHIN = 0.99
"""Share of draws of white noise whose autocorrelation at a lag lies within the band."""
MOST_QUANTILES = 1000


def whitened(residuals: Residuals) -> Chart:
    """Draw for each channel the autocorrelation by lag, and the quantiles against those of the
    normal distribution.

    If the fitted noise is right, residuals that are whitened with it are independent draws of the
    standard normal distribution. The bars then lie within the band, and the points on the line.
    """
    panels: list[Panel] = []
    for channel, values in (
        ("capture", residuals.capture_whitened),
        ("reference", residuals.reference_whitened),
    ):
        if values is not None and values.size >= LEAST_ROWS and float(np.ptp(values)) > 0.0:
            panels += [_autocorrelation(channel, values), _quantiles(channel, values)]
    words = "Whitened residuals: autocorrelation by lag, and quantiles against normal ones."
    return Chart("whitened", words, panels, columns=2, panel_height=2.6)


def _autocorrelation(channel: str, values: Float) -> Panel:
    lags = np.arange(1.0, min(LAGS, values.size // 4) + 1.0)
    reach = float(ndtri(0.5 + 0.5 * WITHIN)) / np.sqrt(values.size)
    ends = np.array([0.5, lags[-1] + 0.5])
    level = np.full(2, reach)
    layers: list[Layer] = [
        Band(ends, -level, level, f"white noise: {100.0 * WITHIN:g} % at each lag", QUIET),
        Bars(lags, autocorrelations(values, lags.size), "residual", CHANNEL_COLOUR[channel]),
    ]
    title = f"{channel.capitalize()}: whitened residual, neighbours"
    return Panel(Axis("lag, rows"), Axis("autocorrelation"), layers, title)


def _quantiles(channel: str, values: Float) -> Panel:
    count = min(values.size, MOST_QUANTILES)
    share = (np.arange(count) + 0.5) / count
    expected, found = ndtri(share), np.quantile(values, share)
    ends = expected[[0, -1]]
    layers: list[Layer] = [
        Curve(ends, ends, "normal", QUIET, dash="dash", width=1.2),
        Curve(expected, found, "residual", CHANNEL_COLOUR[channel], kind="points", size=2.5),
    ]
    title = f"{channel.capitalize()}: whitened residual, sizes"
    return Panel(Axis("normal quantile, σ"), Axis("residual, σ"), layers, title)
