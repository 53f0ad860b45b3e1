"""Draws measurement and model over the angle for both channels."""

from __future__ import annotations

from arctrue.report.analysis import Analysis
from arctrue.report.charts.angle_window import AngleWindow
from arctrue.report.charts.chart import (
    ARCSEC,
    CHANNEL_COLOUR,
    QUIET,
    Axis,
    Band,
    Chart,
    Curve,
    Panel,
)
from arctrue.workbench.observations import CaptureRows

_BINS = 360
_MOST_POINTS = 1500


def measurement_and_model(analysis: Analysis, *, whitened: bool = False) -> Chart:
    """Draw the measured rows, and the mean of the model in 360 bins of the angle. If there are more
    than 1,500 rows, draw only their mean and range (lowest to highest) in each bin.

    ``whitened``: measurement and model are multiplied by the inverse root of the noise's
    covariance, so that noise alone has the standard deviation 1.
    """
    panels = [_panel(analysis, channel, whitened) for channel in analysis.observations.channels]
    how = "whitened" if whitened else "as measured"
    return Chart(
        "measurement_and_model",
        f"Measurement and model over the angle of the table, {how}: "
        f"{', '.join(analysis.model.names())}.",
        panels,
    )


def _panel(analysis: Analysis, channel: str, whitened: bool) -> Panel:
    measured = analysis.measured(channel)
    model = measured - analysis.left(channel)
    if whitened:
        noise = analysis.solution.noise
        of_rows = noise.capture if channel == "capture" else noise.reference
        assert of_rows is not None
        measured, model = of_rows.whiten(measured), of_rows.whiten(model)
    angle, rows = analysis.angle_rad(channel), analysis.rows(channel)
    if isinstance(rows, CaptureRows) and rows.channel is not None:
        # Only head 2 is drawn, because the difference of each further head to head 1 is another
        # function of the angle.
        of_head2 = rows.channel == 0
        measured, model, angle = measured[of_head2], model[of_head2], angle[of_head2]
    colour = CHANNEL_COLOUR[channel]
    window = AngleWindow.over(angle)
    seen, predicted = window.bins(angle, measured, _BINS), window.bins(angle, model, _BINS)
    what = "R₂ − R₁ − α" if channel == "capture" else "error of head 1"
    layers: list[Band | Curve] = []
    if measured.size <= _MOST_POINTS:
        layers.append(
            Curve(
                window.degrees(angle),
                measured,
                "measured",
                colour,
                kind="points",
                size=3.5,
                marker="circle",
            )
        )
    else:
        layers.append(Band(seen.centre, seen.low, seen.high, "measured, lowest to highest", colour))
        layers.append(Curve(seen.centre, seen.mean, "measured, mean", colour, width=1.2))
    layers.append(
        Curve(predicted.centre, predicted.mean, "model", "#1c2530", dash="dash", width=1.4)
    )
    if channel == "reference" and predicted.centre.size < _BINS // 3:
        layers[-1] = Curve(
            predicted.centre,
            predicted.mean,
            "model",
            QUIET,
            kind="both",
            dash="dash",
            marker="hollow",
        )
    return Panel(
        window.axis(),
        Axis(what, "standard deviations" if whitened else ARCSEC),
        layers,
        title=f"{channel.capitalize()}: measurement and model",
    )
