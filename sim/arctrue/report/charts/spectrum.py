"""Draws the lines (sine components) in the residual of the model: by order of the turn, by
frequency, and by period."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from arctrue.base.percent import percent
from arctrue.report.charts.chart import (
    ARCSEC,
    CHANNEL_COLOUR,
    QUIET,
    Axis,
    Chart,
    Curve,
    Layer,
    Panel,
)
from arctrue.workbench.inference.line_spectrum import LineSpectrum, line_spectrum
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.observations.one_speed import speed_turns_s

Float = NDArray[np.float64]
Along = Literal["order", "hz", "s"]
ALONG: dict[Along, str] = {"order": "order of the turn", "hz": "frequency", "s": "period"}
_UNITS = {"order": "1", "hz": "Hz", "s": "s"}
_LABELS = {"order": "order, cycles a turn", "hz": "frequency", "s": "period"}

CHANCE_P = 0.01
_MARKED = 3
"""Number of lines that are labelled with order, frequency or period."""
_HEADROOM = 1.25
"""Factor for the free space above the highest line, where its label is drawn."""
_MOST_ABOVE = 3.0
"""Largest ratio of the height of the panel to the highest line."""
_MOST_POINTS = 2000
"""Only the highest point of each group of k neighbours is drawn, where k is the number of points
divided by this number, rounded down."""


def spectrum(residuals: Residuals, along: Along = "order") -> Chart:
    """Draw the amplitude of a line at every order, frequency or period, for each channel in which
    lines can be found.

    See :func:`all_spectra`.
    """
    panels = [_panel(residuals, channel, along) for channel in residuals.observations.channels]
    words = f"Amplitude of lines in the residual, by {ALONG[along]}."
    return Chart("spectrum", words, panels, panel_height=2.5)


def all_spectra(residuals: Residuals) -> Chart:
    """Draw orders, frequencies and periods in three columns, with one row per channel.

    One in a hundred draws of the fitted noise exceeds the dashed line somewhere in its panel.
    """
    panels = [
        _panel(residuals, channel, along)
        for channel in residuals.observations.channels
        for along in ALONG
    ]
    words = "Amplitude of lines in the residual, by order, frequency and period."
    return Chart("spectra", words, panels, columns=len(ALONG), panel_height=2.6)


def _panel(residuals: Residuals, channel: str, along: Along) -> Panel:
    is_capture = channel == "capture"
    found = line_spectrum(residuals, capture=is_capture, in_time=along != "order")
    title = f"{channel.capitalize()}: lines by {ALONG[along]}"
    y = Axis("amplitude", ARCSEC)
    if found is None or found.rates.size == 0:
        return Panel(Axis(_LABELS[along], _UNITS[along]), y, [], f"{title}: cannot be computed")
    rows = residuals.observations.capture if is_capture else residuals.observations.reference
    if along == "order" and rows is not None:
        speed = speed_turns_s(rows, float(found.rates[-1]))
        title += f", from {found.rates.min():.3g}"
        title += "" if speed is None else f" (one speed: order 1 is {speed:.4g} Hz too)"
    places = 1.0 / found.rates if along == "s" else found.rates
    # ``limit``: reduction of χ² by the two coefficients of a line. Noise alone exceeds it at some
    # rate with the probability CHANCE_P. The noise differs between rates, and therefore also the
    # amplitude at the limit.
    limit = 2.0 * np.log(max(found.trials, 1.0) / CHANCE_P)
    chance = found.amplitude_arcsec * np.sqrt(limit / np.maximum(found.gain, 1e-30))
    shown = highest_of_groups(found.amplitude_arcsec)
    layers: list[Layer] = [
        Curve(
            places[shown],
            found.amplitude_arcsec[shown],
            "residual",
            CHANNEL_COLOUR[channel],
            width=1.0,
        ),
        Curve(
            places[shown],
            chance[shown],
            f"noise alone: {percent(CHANCE_P)} of sets",
            QUIET,
            dash="dash",
            width=1.2,
        ),
    ]
    marked = _strongest(found, limit)
    if marked:
        names = [f"{places[index]:.4g}" for index in marked]
        heights = found.amplitude_arcsec[marked]
        layers.append(
            Curve(places[marked], heights, "", CHANNEL_COLOUR[channel], kind="points", labels=names)
        )
    x = Axis(_LABELS[along], _UNITS[along], logarithmic=True)
    # The scale ignores high limits of coloured noise at the lowest rates, which would make all
    # lines too small to see.
    highest = float(max(found.amplitude_arcsec.max(), np.median(chance)))
    top = max(highest, min(float(chance.max()), _MOST_ABOVE * highest))
    y = Axis("amplitude", ARCSEC, reach=(0.0, _HEADROOM * top))
    return Panel(x, y, layers, title)


def highest_of_groups(amplitude: Float) -> NDArray[np.int64]:
    """Return the index of the highest point in each group of neighbours, so that the picture shows
    every line. The last group may be smaller than the others."""
    group = max(amplitude.size // _MOST_POINTS, 1)
    groups = -(-amplitude.size // group)
    shaped = np.full(groups * group, -np.inf)
    shaped[: amplitude.size] = amplitude
    return np.asarray(np.argmax(shaped.reshape(groups, group), axis=1) + group * np.arange(groups))


def _strongest(found: LineSpectrum, limit: float) -> list[int]:
    """Return the indices of the highest lines above the limit that are at least a line's width
    apart."""
    gain = found.gain.copy()
    strongest: list[int] = []
    width = 2.0 / found.span
    while len(strongest) < _MARKED:
        index = int(np.argmax(gain))
        if gain[index] < limit:
            break
        strongest.append(index)
        gain[np.abs(found.rates - found.rates[index]) < width] = 0.0
    return strongest
