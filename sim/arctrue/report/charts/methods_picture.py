"""Draws the residual of every method by order, and the noise gains."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from arctrue.report.legend_below import legend_below
from arctrue.report.log_scale import set_log_y
from arctrue.report.picture_file import save_picture
from arctrue.report.svg import AFTER, BEFORE, LIMIT, house_style

PICTURE = "methods.svg"
SMALLEST_ARCSEC = 1e-4
"""Lower end of the picture's scale, arcseconds."""


def plot_methods(found: Mapping[str, Any], folder: Path) -> Path:
    """Draw the residual of every method by order, and the noise gain of two, three and four
    heads."""
    path = folder / PICTURE
    with house_style():
        figure = Figure(figsize=(9.6, 9.6), layout="constrained")
        table, gains = figure.subplots(2, 1, height_ratios=[3, 2])
        entries = found["methods"]
        amplitude = np.array([one["amplitude_arcsec"] for one in entries])
        image = table.imshow(
            np.log10(np.maximum(amplitude[:, :40], SMALLEST_ARCSEC)),
            aspect="auto",
            cmap="magma_r",
            extent=(0.5, 40.5, len(entries) - 0.5, -0.5),
            vmin=np.log10(SMALLEST_ARCSEC),
            vmax=0.0,
            interpolation="nearest",
        )
        table.set_yticks(range(len(entries)), [one["title"] for one in entries], fontsize=8)
        table.set_xlabel("order")
        table.grid(visible=False)
        table.set_title("Amplitude of the remaining error of each method, by order")
        bar = figure.colorbar(image, ax=table, pad=0.01, ticks=[-4, -3, -2, -1, 0])
        bar.ax.set_yticklabels(["10⁻⁴″", "10⁻³″", "0.01″", "0.1″", "1″"])
        colours = (BEFORE, LIMIT, "#3a7d44", "#8a6fb0", AFTER, "#888888")
        for one, colour in zip(found["places"], colours, strict=True):
            gain = [np.nan if value is None else value for value in one["gain"]]
            places = ", ".join(f"{p:g}°" for p in one["places_deg"])
            gains.plot(
                range(1, len(gain) + 1), gain, color=colour, linewidth=1.2,
                label=f"{one['title']}: {places}",
            )  # fmt: skip
        set_log_y(gains)
        gains.set_xlabel("order")
        gains.set_ylabel("noise / noise of one head")
        gains.set_title("Noise gain of two, three and four heads (gap: order not determined)")
        legend_below(gains, columns=2)
        return save_picture(figure, path)
