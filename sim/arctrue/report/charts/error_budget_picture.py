"""Draws the sources of the calibration's error, and its uncertainty over the angle."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from arctrue.report.legend_below import legend_below
from arctrue.report.log_scale import set_log_x
from arctrue.report.picture_file import save_picture
from arctrue.report.svg import AFTER, BEFORE, LIMIT, MUTED, house_style

PICTURE = "calibration_budget.svg"


def plot_error_budget(found: Mapping[str, Any], folder: Path) -> Path:
    """Draw every source as a bar, and the expanded uncertainty U over the angle."""
    path = folder / PICTURE
    own = found["methods"]["least_squares"]
    paper = found["methods"]["paper"]
    with house_style():
        figure = Figure(figsize=(9.6, 7.6), layout="constrained")
        bars, curve = figure.subplots(2, 1, height_ratios=[3, 2])
        place = np.arange(len(own["sources"]))
        for shift, one, colour, label in (
            (-0.2, paper, BEFORE, "the paper's method"),
            (0.2, own, AFTER, "least squares"),
        ):
            values = [max(row["rms_arcsec"], 1e-5) for row in one["sources"]]
            bars.barh(place + shift, values, 0.38, color=colour, label=label)
            bars.axvline(one["whole"]["rms_arcsec"], color=colour, linestyle=(0, (4, 3)))
        set_log_x(bars)
        bars.set_yticks(place, [row["title"] for row in own["sources"]], fontsize=8)
        bars.invert_yaxis()
        bars.set_xlabel("RMS, ″; dashed line: all sources together")
        bars.set_title("Each source alone")
        legend_below(bars, columns=2)
        for name, colour, label in (
            ("drawn", MUTED, "all sources, simulated"),
            ("covariance", AFTER, "partial: covariance of noise, quantisation and α"),
            ("of_alpha", BEFORE, "α alone"),
            ("of_noise", LIMIT, "noise and quantisation alone"),
        ):
            curve.plot(
                found["angle_deg"], own["by_angle"][f"{name}_arcsec"], color=colour, label=label
            )
        curve.set_ylim(bottom=0.0)
        curve.set_xlim(0, 360)
        curve.set_xticks(range(0, 361, 45))
        curve.set_xlabel("reading, °")
        curve.set_ylabel("2 u, ″")
        curve.set_title("Uncertainty over the turn: all sources, and the covariance")
        legend_below(curve, columns=2)
        return save_picture(figure, path)
