"""What the model leaves over the angle, each run and each direction by itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arctrue.report.charts.bins import of_turn
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
    angle_axis,
    signed,
)
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.observations import CaptureRows, ReferenceRows

Float = NDArray[np.float64]

_MOST_RUNS = 12
_FEW_STATIONS, _APART_DEG, _EDGE_DEG = 60, 1.6, 3.0
"""Up to so many stations, those of the directions are drawn side by side."""
_DASHES: tuple[Dash, ...] = ("solid", "dash", "dot")
_MARKERS: tuple[Marker, ...] = ("circle", "hollow", "diamond")


def branches(residuals: Residuals, noise_arcsec: Mapping[str, float]) -> Chart:
    """Means each two degrees by run in the capture, stations by direction in the reference.

    ``noise_arcsec``: of the repeats, by channel.
    """
    panels = []
    capture, reference = residuals.observations.capture, residuals.observations.reference
    if capture is not None and residuals.capture_arcsec is not None:
        panels.append(_runs(capture, residuals.capture_arcsec, noise_arcsec.get("capture", 0.0)))
    if reference is not None and residuals.reference_arcsec is not None:
        noise = noise_arcsec.get("reference", 0.0)
        panels.append(_stations(reference, residuals.reference_arcsec, noise))
    return Chart(
        "branches", "What the model leaves over the angle, by run and by direction.", panels
    )


def _runs(rows: CaptureRows, left: Float, noise: float) -> Panel:
    layers: list[Curve | Band] = []
    each = 1.0
    for place, run in enumerate(range(min(rows.runs, _MOST_RUNS))):
        inside = rows.run == run
        mean = of_turn(rows.angle_rad[inside], left[inside])
        each = float(mean.rows.mean()) if mean.rows.size else 1.0
        name = f"run {run}: {signed(np.degrees(float(np.median(rows.speed_rad_s[inside]))), 1)} °/s"
        if rows.temperature_c is not None:
            name += f", {float(np.mean(rows.temperature_c[inside])):.1f} °C"
        colour = COLOURS[place % len(COLOURS)]
        dash = _DASHES[place // len(COLOURS) % len(_DASHES)]
        layers.append(Curve(mean.centre, mean.mean, name, colour, dash=dash, width=1.2))
    layers.insert(0, _noise_band(2.0 * noise / np.sqrt(max(each, 1.0))))
    title = "Capture: what the model leaves in each run, mean each 2°"
    if rows.runs > _MOST_RUNS:
        title += f" (the first {_MOST_RUNS} of {rows.runs} runs)"
    x = angle_axis(over_deg=np.mod(np.degrees(rows.angle_rad), 360.0))
    return Panel(x, Axis("R₂ − R₁ less the model", ARCSEC), layers, title)


def _stations(rows: ReferenceRows, left: Float, noise: float) -> Panel:
    side = np.ones(left.size) if rows.direction is None else rows.direction
    degrees = np.mod(np.degrees(rows.target_rad), 360.0)
    layers: list[Curve | Band] = [_noise_band(2.0 * noise)]
    directions = np.unique(side)
    stations = np.unique(np.round(degrees, 4)).size
    apart = _APART_DEG if stations <= _FEW_STATIONS and directions.size > 1 else 0.0
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
    title = "Reference run: what the model leaves at each station"
    x = angle_axis(over_deg=degrees)
    if x.reach is not None:
        x = replace(x, reach=(x.reach[0] - _EDGE_DEG, x.reach[1] + _EDGE_DEG))
    return Panel(x, Axis("error less the model", ARCSEC), layers, title)


def _noise_band(reach: float) -> Band:
    ends = np.array([0.0, 360.0])
    return Band(ends, np.full(2, -reach), np.full(2, reach), "noise of repeats, ±2σ", QUIET, 0.25)
