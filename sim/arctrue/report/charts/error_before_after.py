"""Error of the demo's output over one turn, before and after, from lowest to highest edge."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.report.charts.chart import QUIET, Axis, Band, Chart, Layer, Level, Panel, angle_axis
from arctrue.report.svg import AFTER, BEFORE
from arctrue.studies.demo.result import DemoResult

_BINS = 1440
"""A quarter of a degree each."""


def error_before_after(result: DemoResult) -> Chart:
    """Both turns; below, the one after compensation enlarged, with its limits."""
    settings, limit = result.settings, result.settings.peak_limit_counts
    turns = (
        _band(result.before.true_angle_rad, result.before.error_counts, BEFORE, "before"),
        _band(result.after.true_angle_rad, result.after.error_counts, AFTER, "after"),
    )
    x = angle_axis("true angle of the table")
    also = ("arcsec", settings.arcsec_per_count)
    limits: list[Layer] = [
        Level(limit, f"limit ±{limit:g} counts", QUIET),
        Level(-limit, "", QUIET),
    ]
    reach = max(limit, result.after.peak_counts) * 1.3
    return Chart(
        "error_before_after",
        f"Error of the output over a turn: up to {result.before.peak_counts:.1f} counts before, "
        f"{result.after.peak_counts:.2f} after.",
        [
            Panel(x, Axis("error", "counts", also=also), turns, "Output against the true angle"),
            Panel(
                x,
                Axis("error", "counts", also=also, reach=(-reach, reach)),
                [turns[1], *limits],
                "After compensation, enlarged",
            ),
        ],
    )


def _band(
    angle_rad: NDArray[np.float64], error: NDArray[np.float64], colour: str, name: str
) -> Band:
    # Every edge counts: each part of the turn is drawn from its lowest to its highest edge.
    angle_deg = np.rad2deg(angle_rad)
    place = np.minimum((angle_deg * (_BINS / 360)).astype(np.int64), _BINS - 1)
    lowest, highest = np.full(_BINS, np.inf), np.full(_BINS, -np.inf)
    np.minimum.at(lowest, place, error)
    np.maximum.at(highest, place, error)
    filled = highest >= lowest
    middle = (np.arange(_BINS) + 0.5) * (360 / _BINS)
    return Band(middle[filled], lowest[filled], highest[filled], name, colour, opacity=1.0)
