"""Draws Fig. 11 of the paper from its experiment on the virtual instrument."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from arctrue.report.charts.chart import (
    ARCSEC,
    COLOURS,
    Axis,
    Bars,
    Chart,
    Curve,
    Level,
    Panel,
    angle_axis,
)
from arctrue.report.charts.matplotlib_chart import save_chart

BEFORE, AFTER = COLOURS[1], COLOURS[0]
DEVIATION_SCALE = 300
"""Factor by which the deviations are enlarged, as in the paper, so that they are visible next to
150″."""


def figure_11_name(found: Mapping[str, Any]) -> str:
    """Return the file name of Fig. 11; for fewer counts than in the paper it contains the
    interpolation factor."""
    interpolation = found["settings"]["revolution"]["interpolation"]
    return "paper_fig_11.png" if interpolation == 1024 else f"paper_fig_11_x{interpolation}.png"


def plot_experiment(found: Mapping[str, Any], folder: Path) -> Path:
    """Write Fig. 11; ``found`` is the content of ``ExperimentResult.as_json()``, from a run or a
    file."""
    return save_chart(experiment_chart(found), folder / figure_11_name(found))


def experiment_chart(found: Mapping[str, Any]) -> Chart:
    """Draw (a) the error at every face before and after correction, and the corrected error
    enlarged; (b) the amplitudes of the orders."""
    published = found["published"]
    faces, cycles = published["faces"], found["settings"]["cycles"]
    whole = Panel(
        angle_axis("true angle"),
        Axis("error", ARCSEC),
        [
            _errors(found["before"], BEFORE, "uncorrected", DEVIATION_SCALE),
            _errors(found["after"], AFTER, "corrected", DEVIATION_SCALE),
        ],
        f"(a) Error at {faces} faces, {cycles} cycles; "
        f"bars: σ of equation (13) × {DEVIATION_SCALE}",
    )
    enlarged = Panel(
        angle_axis("true angle"),
        Axis("error", ARCSEC),
        [
            _errors(found["after"], AFTER, "", 1),
            *(Level(limit) for limit in published["after_arcsec"]),
        ],
        "Corrected, enlarged; bars: σ; dashed: the paper's range",
    )
    amplitude = np.asarray(found["residual_orders_arcsec"])
    numbers = np.arange(1.0, amplitude.size + 1.0)
    orders = Panel(
        Axis("order", ticks=[(float(n), f"{n:.0f}") for n in numbers]),
        Axis("amplitude", ARCSEC),
        [Bars(numbers, amplitude, "", AFTER), Level(expected_order_arcsec(published))],
        "(b) Orders of the corrected error; dashed: orders that independent u₁ and u₂ cause",
    )
    words = f"Fig. 11: error at {faces} faces before and after, and the orders that are left."
    return Chart("paper_fig_11", words, [whole, enlarged, orders])


def _errors(errors: Mapping[str, Any], colour: str, name: str, scale: float) -> Curve:
    mean = np.asarray(errors["mean_arcsec"])
    deviation = np.asarray(errors["deviation_arcsec"])
    angle_deg = np.arange(mean.size) * (360.0 / mean.size)
    return Curve(
        angle_deg, mean, name, colour, kind="both", y_error=scale * deviation, width=1.2, size=3.0
    )


def expected_order_arcsec(published: Mapping[str, Any]) -> float:
    """Return the RMS amplitude of an order that independent errors u₁ and u₂ of the faces cause."""
    budget = published["budget"]
    face_arcsec = np.hypot(budget["polygon_arcsec"], budget["autocollimator_arcsec"])
    return float(2.0 * face_arcsec / np.sqrt(published["faces"]))
