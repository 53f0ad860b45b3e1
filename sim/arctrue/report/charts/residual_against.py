"""Draws the residual over one condition, for example temperature, speed, time or phase."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.report.analysis import Analysis, Condition
from arctrue.report.charts.angle_window import AngleWindow
from arctrue.report.charts.bins import Bins, of_values
from arctrue.report.charts.chart import (
    ARCSEC,
    CHANNEL_COLOUR,
    Axis,
    Chart,
    Curve,
    Layer,
    Level,
    Panel,
)

Float = NDArray[np.float64]

_ROUND_BINS = 72


def residual_against(analysis: Analysis, condition: Condition) -> Chart:
    """Draw mean and standard error of the residual in bins of the condition, for both channels.

    The standard error assumes independent rows; with slow noise the means scatter more.
    """
    panels = []
    for channel, values in condition.values.items():
        left = analysis.left(channel)
        seen = bins_over(condition, values, left - left.mean())
        layers: list[Layer] = [
            Level(0.0),
            Curve(
                seen.centre,
                seen.mean,
                "",
                CHANNEL_COLOUR[channel],
                kind="both" if condition.goes_round and channel == "capture" else "points",
                y_error=seen.standard_error,
            ),
        ]
        panels.append(
            Panel(
                _axis(condition, values),
                Axis("mean residual", ARCSEC),
                layers,
                title=channel.capitalize(),
            )
        )
    return Chart(
        "residual_against",
        f"Mean residual against {condition.name}.",
        panels,
        columns=2,
        panel_height=3.0,
    )


def _axis(condition: Condition, values: Float) -> Axis:
    if condition.goes_round:
        return AngleWindow.over(values).axis(condition.name)
    return Axis(condition.name, condition.unit)


def bins_over(condition: Condition, values: Float, left: Float) -> Bins:
    """Return the mean residual in bins of a condition.

    The bins divide the turn, or the range from the lowest to the highest value; a few distinct
    values have a bin each.
    """
    if condition.goes_round:
        places = np.unique(np.round(np.mod(values, 2.0 * np.pi), 6)).size
        return AngleWindow.over(values).bins(values, left, min(_ROUND_BINS, max(places, 1)))
    return of_values(values, left)


def share_of_variance(condition: Condition, values: Float, left: Float) -> float:
    """Return the share of the residual's variance that the means over the condition explain.

    The function subtracts the share that the same number of means of independent noise would
    explain. The difference ranks the conditions until the diagnosis is available.
    """
    centred = left - left.mean()
    whole = float(centred @ centred)
    if whole <= 0.0:
        return 0.0
    seen = bins_over(condition, values, centred)
    taken = float(np.sum(seen.rows * seen.mean**2)) / whole
    return max(taken - (seen.rows.size - 1) / max(left.size - 1, 1), 0.0)
