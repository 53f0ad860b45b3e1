"""Draws the residual over the angle, with one curve for each run (12 at most) or direction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arctrue.report.charts.angle_window import AngleWindow
from arctrue.report.charts.bins import TURN_BINS
from arctrue.report.charts.chart import (
    ARCSEC,
    COLOURS,
    QUIET,
    Axis,
    Band,
    Chart,
    Curve,
    Dash,
    Marker,
    Panel,
    signed,
)
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.observations import CaptureRows, ReferenceRows

Float = NDArray[np.float64]

_MOST_RUNS = 12
_FEW_STATIONS, _APART, _EDGE = 60, 1.6 / 360.0, 3.0 / 360.0
"""Largest number of stations for which the two directions are drawn side by side. The other two
values are the distance between the directions and the margin at the ends, as shares of the axis."""
_DASHES: tuple[Dash, ...] = ("solid", "dash", "dot")
_MARKERS: tuple[Marker, ...] = ("circle", "hollow", "diamond")


def branches(residuals: Residuals, noise_arcsec: Mapping[str, float]) -> Chart:
    """Draw the mean residual in 180 bins of the angle as a curve for each of the first 12 runs of
    the capture. Draw each row of the reference as a point, coloured by direction.

    ``noise_arcsec``: standard deviation of repeated measurements, by channel.
    """
    panels = []
    capture, reference = residuals.observations.capture, residuals.observations.reference
    if capture is not None and residuals.capture_arcsec is not None:
        panels.append(_runs(capture, residuals.capture_arcsec, noise_arcsec.get("capture", 0.0)))
    if reference is not None and residuals.reference_arcsec is not None:
        noise = noise_arcsec.get("reference", 0.0)
        panels.append(_stations(reference, residuals.reference_arcsec, noise))
    return Chart(
        "branches", "Residual of the model over the angle, by run and by direction.", panels
    )


def _runs(rows: CaptureRows, left: Float, noise: float) -> Panel:
    layers: list[Curve | Band] = []
    each = 1.0
    window = AngleWindow.over(rows.angle_rad)
    for place, run in enumerate(range(min(rows.runs, _MOST_RUNS))):
        inside = rows.run == run
        mean = window.bins(rows.angle_rad[inside], left[inside], TURN_BINS)
        each = float(mean.rows.mean()) if mean.rows.size else 1.0
        speed_deg_s = np.degrees(float(np.median(rows.speed_rad_s[inside])))
        name = f"{rows.run_words(run)}: {signed(speed_deg_s, 1)} °/s"
        if rows.temperature_c is not None:
            name += f", {float(np.mean(rows.temperature_c[inside])):.1f} °C"
        colour = COLOURS[place % len(COLOURS)]
        dash = _DASHES[place // len(COLOURS) % len(_DASHES)]
        layers.append(Curve(mean.centre, mean.mean, name, colour, dash=dash, width=1.2))
    layers.insert(0, _noise_band(window, 2.0 * noise / np.sqrt(max(each, 1.0))))
    title = f"Capture: residual of each run, mean each {window.span_deg / TURN_BINS:.2g}°"
    if rows.runs > _MOST_RUNS:
        title += f" (the first {_MOST_RUNS} of {rows.runs} runs)"
    measured = "R₂ − R₁" if rows.channel is None else "Differences of the heads"
    return Panel(window.axis(), Axis(f"{measured} less the model", ARCSEC), layers, title)


def _stations(rows: ReferenceRows, left: Float, noise: float) -> Panel:
    side = np.ones(left.size) if rows.direction is None else rows.direction
    window = AngleWindow.over(rows.target_rad)
    degrees = window.degrees(rows.target_rad)
    layers: list[Curve | Band] = [_noise_band(window, 2.0 * noise)]
    directions = np.unique(side)
    stations = np.unique(np.round(degrees, 4)).size
    apart = _APART * window.span_deg if stations <= _FEW_STATIONS and directions.size > 1 else 0.0
    for place, value in enumerate(directions):
        inside = side == value
        shift = apart * (place - (directions.size - 1) / 2.0)
        layers.append(
            Curve(
                degrees[inside] + shift,
                left[inside],
                f"direction {signed(float(value), 0)}",
                COLOURS[place % len(COLOURS)],
                kind="points",
                marker=_MARKERS[place % len(_MARKERS)],
                size=4.0,
            )
        )
    title = "Reference run: residual at each station"
    x = window.axis()
    if x.reach is not None:
        edge = _EDGE * window.span_deg
        x = replace(x, reach=(x.reach[0] - edge, x.reach[1] + edge))
    return Panel(x, Axis("error less the model", ARCSEC), layers, title)


def _noise_band(window: AngleWindow, reach: float) -> Band:
    ends = np.array([window.start_deg, window.end_deg])
    return Band(ends, np.full(2, -reach), np.full(2, reach), "noise of repeats, ±2σ", QUIET, 0.25)
