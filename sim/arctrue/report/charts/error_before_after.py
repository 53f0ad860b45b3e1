"""Draws the demo's output error over one turn, before and after compensation."""

from __future__ import annotations

import numpy as np

from arctrue.instrument.turn_score import TurnScore
from arctrue.report.charts.chart import QUIET, Axis, Band, Chart, Layer, Level, Panel, angle_axis
from arctrue.report.svg import AFTER, BEFORE
from arctrue.studies.demo.result import DemoResult


def error_before_after(result: DemoResult) -> Chart:
    """Draw the turns before and after compensation; below, draw the compensated turn enlarged, with
    its limits."""
    settings, limit = result.settings, result.settings.peak_limit_counts
    count = settings.arcsec_per_count
    turns = (
        _band(result.before, count, BEFORE, "before"),
        _band(result.after, count, AFTER, "after"),
    )
    before, after = (turn.edges_reach_arcsec / count for turn in (result.before, result.after))
    x = angle_axis("true angle of the table")
    also = ("arcsec", count)
    limits: list[Layer] = [
        Level(limit, f"limit ±{limit:g} counts", QUIET),
        Level(-limit, "", QUIET),
    ]
    reach = max(limit, after) * 1.3
    return Chart(
        "error_before_after",
        f"Error of the output over a turn: up to {before:.1f} counts before, {after:.2f} after.",
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


def _band(turn: TurnScore, count_arcsec: float, colour: str, name: str) -> Band:
    # Each half degree is drawn from its lowest to its highest edge, so that the band contains every
    # edge.
    filled = np.isfinite(turn.error_arcsec)
    return Band(
        np.rad2deg(turn.angle_rad)[filled],
        turn.lowest_edge_arcsec[filled] / count_arcsec,
        turn.highest_edge_arcsec[filled] / count_arcsec,
        name,
        colour,
        opacity=1.0,
    )
