"""Fig. 11 of the paper, drawn anew from a run of its experiment on the virtual instrument."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from arctrue.report.png import COLOURS, QUIET, plain_axes, png_figure, save_png

BEFORE, AFTER = COLOURS[1], COLOURS[0]
DEVIATION_SCALE = 300
"""The paper's own, so that deviations can be seen beside 150″."""


def figure_11_name(found: Mapping[str, Any]) -> str:
    """File of Fig. 11: that of a run with coarser counts has its interpolation in the name."""
    interpolation = found["settings"]["revolution"]["interpolation"]
    return "paper_fig_11.png" if interpolation == 1024 else f"paper_fig_11_x{interpolation}.png"


def plot_experiment(found: Mapping[str, Any], folder: Path) -> Path:
    """(a) error at every face, and corrected, enlarged; (b) its orders.

    ``found``: ``ExperimentResult.as_json()``, from a run or a file.
    """
    published = found["published"]
    faces = np.arange(published["faces"])
    angle_deg = faces * (360.0 / faces.size)
    figure = png_figure(8.6, 8.4)
    whole, enlarged, orders = figure.subplots(3, 1, height_ratios=[3, 2, 2])
    for errors, colour, label in (
        (found["before"], BEFORE, "uncorrected"),
        (found["after"], AFTER, "corrected"),
    ):
        whole.errorbar(
            angle_deg,
            errors["mean_arcsec"],
            yerr=DEVIATION_SCALE * np.asarray(errors["deviation_arcsec"]),
            color=colour,
            marker="o",
            markersize=3,
            linewidth=1.2,
            capsize=2,
            elinewidth=0.7,
            label=label,
        )
    whole.legend(frameon=False, ncols=2, loc="lower right")
    whole.set_title(
        f"(a) Error at {faces.size} faces, {found['settings']['cycles']} cycles; "
        f"bars: σ of equation (13) × {DEVIATION_SCALE}",
        loc="left",
    )
    enlarged.errorbar(
        angle_deg,
        found["after"]["mean_arcsec"],
        yerr=found["after"]["deviation_arcsec"],
        color=AFTER,
        marker="o",
        markersize=3,
        linewidth=1.2,
        capsize=2,
        elinewidth=0.7,
    )
    for limit in published["after_arcsec"]:
        enlarged.axhline(limit, color=QUIET, linestyle=(0, (4, 3)), linewidth=1)
    enlarged.set_title("Corrected, enlarged; bars: σ; broken: the paper's range", loc="left")
    for axes in (whole, enlarged):
        axes.set_ylabel("error, ″")
        axes.set_xlim(-5, 360)
        axes.set_xticks(range(0, 361, 45))
        plain_axes(axes)
    enlarged.set_xlabel("true angle, °")
    amplitude = np.asarray(found["residual_orders_arcsec"])
    numbers = np.arange(1, amplitude.size + 1)
    orders.bar(numbers, amplitude, color=AFTER, width=0.6)
    orders.axhline(
        expected_order_arcsec(published), color=QUIET, linestyle=(0, (4, 3)), linewidth=1
    )
    orders.set_title(
        "(b) Orders of the corrected error; broken: what u₁ and u₂ of independent faces give",
        loc="left",
    )
    orders.set_xlabel("order")
    orders.set_ylabel("amplitude, ″")
    orders.set_xticks(numbers)
    plain_axes(orders)
    return save_png(figure, folder, figure_11_name(found))


def expected_order_arcsec(published: Mapping[str, Any]) -> float:
    """RMS amplitude of an order that independent errors of the faces of u₁ and u₂ have."""
    budget = published["budget"]
    face_arcsec = np.hypot(budget["polygon_arcsec"], budget["autocollimator_arcsec"])
    return float(2.0 * face_arcsec / np.sqrt(published["faces"]))
