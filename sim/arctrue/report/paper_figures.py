"""Fig. 11 of the paper, drawn anew from a run of its experiment on the virtual instrument."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from arctrue.report.png import COLOURS, QUIET, plain_axes, png_figure, save_png
from arctrue.studies.paper.experiment import ExperimentResult

BEFORE, AFTER = COLOURS[1], COLOURS[0]
DEVIATION_SCALE = 300
"""The paper's own, so that deviations can be seen beside 150″."""


def plot_experiment(result: ExperimentResult, folder: Path) -> Path:
    """a: error at every face; b: the same after compensation, enlarged; c: its orders."""
    faces = np.arange(result.published.faces)
    angle_deg = faces * (360.0 / faces.size)
    figure = png_figure(8.6, 8.4)
    whole, enlarged, orders = figure.subplots(3, 1, height_ratios=[3, 2, 2])
    for errors, colour, label in (
        (result.before, BEFORE, "uncorrected"),
        (result.after, AFTER, "corrected"),
    ):
        whole.errorbar(
            angle_deg,
            errors.mean_arcsec,
            yerr=DEVIATION_SCALE * errors.deviation_arcsec,
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
        f"(a) Error at {faces.size} faces, {result.settings.cycles} cycles; "
        f"bars: σ of equation (13) × {DEVIATION_SCALE}",
        loc="left",
    )
    enlarged.errorbar(
        angle_deg,
        result.after.mean_arcsec,
        yerr=result.after.deviation_arcsec,
        color=AFTER,
        marker="o",
        markersize=3,
        linewidth=1.2,
        capsize=2,
        elinewidth=0.7,
    )
    for limit in result.published.after_arcsec:
        enlarged.axhline(limit, color=QUIET, linestyle=(0, (4, 3)), linewidth=1)
    enlarged.set_title("Corrected, enlarged; bars: σ; broken: the paper's range", loc="left")
    for axes in (whole, enlarged):
        axes.set_ylabel("error, ″")
        axes.set_xlim(-5, 360)
        axes.set_xticks(range(0, 361, 45))
        plain_axes(axes)
    enlarged.set_xlabel("true angle, °")
    amplitude = result.residual_orders_arcsec
    numbers = np.arange(1, amplitude.size + 1)
    orders.bar(numbers, amplitude, color=AFTER, width=0.6)
    orders.axhline(_expected_order_arcsec(result), color=QUIET, linestyle=(0, (4, 3)), linewidth=1)
    orders.set_title(
        "(b) Orders of the corrected error; broken: what the polygon's uncertainty alone gives",
        loc="left",
    )
    orders.set_xlabel("order")
    orders.set_ylabel("amplitude, ″")
    orders.set_xticks(numbers)
    plain_axes(orders)
    return save_png(figure, folder, "paper_fig_11.png")


def _expected_order_arcsec(result: ExperimentResult) -> float:
    """RMS amplitude of an order that independent errors of the faces of u₁ and u₂ have."""
    budget = result.published.budget
    face_arcsec = np.hypot(budget.polygon_arcsec, budget.autocollimator_arcsec)
    return float(2.0 * face_arcsec / np.sqrt(result.published.faces))
