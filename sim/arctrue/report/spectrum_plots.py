"""Picture of ``arctrue compare``: lines in what a model leaves, by order, period and frequency."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, NullFormatter

from arctrue.report.png import CHANNEL_COLOUR, QUIET, plain_axes, png_figure, save_png
from arctrue.workbench.inference.line_spectrum import (
    LineSpectrum,
    line_spectrum,
    speed_turns_s,
)
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.solution import Solution

MOST_POINTS = 4000
"""Of a curve; of more, the highest of each group is drawn."""
CHANCE_P = 0.01
MARKED = 3
"""Lines whose rate is written beside them."""


def plot_line_spectrum(solution: Solution, folder: Path) -> Path:
    """Amplitude of a line over orders per turn, seconds and Hz: one row a channel; returns a PNG.

    Above the dashed line an amplitude is rarer than one in a hundred draws of the fitted noise,
    over all places of its panel.
    """
    residuals = Residuals(solution)
    channels = [
        (name, capture)
        for name, capture, rows in (
            ("capture", True, solution.observations.capture),
            ("reference", False, solution.observations.reference),
        )
        if rows is not None
    ]
    figure = png_figure(11.0, 0.4 + 3.0 * max(len(channels), 1))
    panels = figure.subplots(max(len(channels), 1), 3, squeeze=False)
    for row, (name, capture) in zip(panels, channels, strict=True):
        angle = line_spectrum(residuals, capture=capture, in_time=False)
        time = line_spectrum(residuals, capture=capture, in_time=True)
        colour = CHANNEL_COLOUR[name]
        _draw(row[0], angle, None if angle is None else angle.rates, colour, "periods a turn")
        _draw(row[1], time, None if time is None else 1.0 / time.rates, colour, "period, s")
        _draw(row[2], time, None if time is None else time.rates, colour, "frequency, Hz")
        title = f"{name.capitalize()}: lines in what the model leaves"
        if angle is not None and angle.rates.size and _one_speed(residuals, capture, angle):
            title += " (one speed: order and frequency are the same line)"
        row[0].set_title(title, loc="left", fontsize=9, fontweight="bold")
        row[0].set_ylabel("amplitude, ″", fontsize=9)
    return save_png(figure, folder, "residual_lines.png")


def _one_speed(residuals: Residuals, capture: bool, spectrum: LineSpectrum) -> bool:
    rows = residuals.observations.capture if capture else residuals.observations.reference
    return rows is not None and speed_turns_s(rows, float(spectrum.rates[-1])) is not None


def _draw(
    axes: Axes, spectrum: LineSpectrum | None, places: np.ndarray | None, colour: str, label: str
) -> None:
    plain_axes(axes)
    axes.tick_params(labelsize=8)
    axes.set_xlabel(label, fontsize=9)
    if spectrum is None or places is None or places.size == 0:
        axes.annotate("not known from this set", (0.5, 0.5), xycoords="axes fraction", ha="center")
        return
    group = max(places.size // MOST_POINTS, 1)
    whole = places.size // group * group
    amplitude, gain = spectrum.amplitude_arcsec, spectrum.gain
    shaped = amplitude[:whole].reshape(-1, group)
    highest = np.argmax(shaped, axis=1) + group * np.arange(shaped.shape[0])
    axes.plot(places[highest], amplitude[highest], color=colour, linewidth=0.8)
    axes.set_xscale("log")
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    # χ² of two coefficients over all places; an amplitude's noise is that of its own rate.
    limit = 2.0 * np.log(max(spectrum.trials, 1.0) / CHANCE_P)
    chance = amplitude * np.sqrt(limit / np.maximum(gain, 1e-30))
    axes.plot(places[highest], chance[highest], color=QUIET, linewidth=0.9, linestyle="--")
    axes.set_ylim(0.0, 1.25 * float(max(amplitude.max(), np.median(chance))))
    for index in _strongest(spectrum, limit):
        axes.annotate(
            f"{places[index]:.4g}",
            (places[index], amplitude[index]),
            xytext=(0, 3),
            textcoords="offset points",
            ha="center",
            fontsize=8,
        )


def _strongest(spectrum: LineSpectrum, limit: float) -> list[int]:
    """The highest lines above chance, each at its own place."""
    gain = spectrum.gain.copy()
    found: list[int] = []
    width = 2.0 / spectrum.span
    while len(found) < MARKED:
        index = int(np.argmax(gain))
        if gain[index] < limit:
            break
        found.append(index)
        gain[np.abs(spectrum.rates - spectrum.rates[index]) < width] = 0.0
    return found
