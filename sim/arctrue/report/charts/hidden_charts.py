"""Draws the error that a hidden effect causes in the gateware's output, over a turn and over a
period of the signal."""

from __future__ import annotations

import numpy as np

from arctrue.instrument.turn_score import TurnScore
from arctrue.report.charts.chart import ARCSEC, Axis, Band, Chart, Curve, Dash, Panel, angle_axis
from arctrue.report.svg import AFTER, BEFORE
from arctrue.studies.hidden_effect.result import HiddenResult

PAPER = "#d0932b"
_NAMES = ("raw", "paper's model", "with the effect")


def three_curves(result: HiddenResult) -> Chart:
    """Draw one turn uncorrected, corrected with the paper's model, and corrected with the effect.

    The two corrected turns are drawn again below, enlarged.
    """
    bands = [
        _band(curve, colour, name)
        for curve, colour, name in zip(
            (result.raw, result.paper, result.corrected),
            (BEFORE, PAPER, AFTER),
            _NAMES,
            strict=True,
        )
    ]
    x, y = angle_axis("true angle of the table"), Axis("error", ARCSEC)
    return Chart(
        "three_curves",
        f"Error of the output over a turn: {result.raw.edges_rms_arcsec:.1f}″ RMS raw, "
        f"{result.paper.edges_rms_arcsec:.3f}″ with the paper's model, "
        f"{result.corrected.edges_rms_arcsec:.3f}″ with the effect.",
        [
            Panel(x, y, bands, "Output against the true angle, every edge"),
            Panel(x, y, bands[1:], "The two corrected turns, enlarged"),
        ],
    )


def _band(curve: TurnScore, colour: str, name: str) -> Band:
    return Band(
        np.rad2deg(curve.angle_rad),
        curve.lowest_edge_arcsec,
        curve.highest_edge_arcsec,
        name,
        colour,
        opacity=1.0,
    )


def signal_period(result: HiddenResult) -> Chart:
    """Draw the mean error over a period of the signal, without the errors of low orders."""
    curves = []
    for curve, colour, name in (
        (result.raw_period, BEFORE, _NAMES[0]),
        (result.paper_period, PAPER, _NAMES[1]),
        (result.corrected_period, AFTER, _NAMES[2]),
    ):
        bins = curve.mean_arcsec.size
        middle_deg = (np.arange(bins) + 0.5) * (360 / bins)
        dash: Dash = "dash" if name == _NAMES[0] else "solid"
        curves.append(Curve(middle_deg, curve.mean_arcsec, name, colour, dash=dash))
    title = "Mean error over a period of the grating, slow errors removed"
    panel = Panel(angle_axis("electrical phase of head 1"), Axis("error", ARCSEC), curves, title)
    return Chart("signal_period", f"{title}.", [panel], panel_height=2.8)
