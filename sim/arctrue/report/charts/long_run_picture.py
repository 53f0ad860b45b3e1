"""Draws temperature, error and Allan deviation of the long run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from arctrue.base.whole_file import whole_file
from arctrue.report.legend_below import legend_below
from arctrue.report.log_scale import set_log_x, set_log_y
from arctrue.report.svg import AFTER, BEFORE, INK, LIMIT, MUTED, house_style

PICTURE = "long_run.svg"
SAID = {
    "held": "calibrated in the first turn only",
    "single": "calibrated from every single turn",
    "average": "calibrated from a running average of the turns (`keep` 0.8)",
    "model": "order 1 by the temperature model, the others by a running average",
}
COLOURS = {"held": LIMIT, "single": BEFORE, "average": INK, "model": AFTER}


def plot_long_run(found: Mapping[str, Any], folder: Path) -> Path:
    """Draw temperature and error over the turns, and the Allan deviation of the orders."""
    path = folder / PICTURE
    turns = np.arange(1, found["turns"] + 1)
    with house_style():
        figure = Figure(figsize=(9.6, 9.0), layout="constrained")
        warmth, left, allan = figure.subplots(3, 1, height_ratios=[1, 2.2, 2.4])
        left.sharex(warmth)
        warmth.plot(turns, found["temperature_c"], color=MUTED)
        warmth.set_ylabel("°C")
        warmth.set_title("Temperature of the table")
        for name, one in found["strategies"].items():
            left.plot(
                turns[2:],
                one["left_arcsec"][2:],
                color=COLOURS[name],
                linewidth=0.9,
                label=SAID[name].replace("`", ""),
            )
        set_log_y(left)
        left.axvline(found["learned_turns"], color=MUTED, linestyle=":", linewidth=1)
        left.set_title("Remaining error (dotted line: last turn to which the model is fitted)")
        left.set_ylabel("RMS, ″")
        left.set_xlabel("turn")
        legend_below(left, columns=2)
        _plot_allan(allan, found)
        folder.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as unfinished:
            figure.savefig(unfinished, format="svg", metadata={"Date": None})
    return path


def _plot_allan(axes: Axes, found: Mapping[str, Any]) -> None:
    lengths = np.asarray(found["allan"]["averaged_turns"], dtype=np.float64)
    colours = (BEFORE, AFTER, INK)
    for colour, (order, deviation) in zip(
        colours, found["allan"]["deviation_arcsec"].items(), strict=False
    ):
        values = np.array([np.nan if value is None else value for value in deviation])
        axes.plot(lengths, values, "o-", color=colour, markersize=3, label=f"order {order}")
        u = found["allan"]["u_arcsec"][order]
        axes.plot(lengths, u / np.sqrt(lengths), "--", color=colour, linewidth=0.8)
    set_log_x(axes)
    set_log_y(axes)
    axes.set_title("Allan deviation of the orders (dashed: stated u of a turn, divided by √m)")
    axes.set_xlabel("number of averaged turns, m")
    axes.set_ylabel("Allan deviation, ″")
    axes.legend(fontsize=8)
