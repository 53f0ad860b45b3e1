"""What the model leaves over the angle, each run and each direction by itself."""

from __future__ import annotations

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
from arctrue.report.examined import Examined
from arctrue.workbench.observations import CaptureRows, ReferenceRows

Float = NDArray[np.float64]

_MOST_RUNS = 12
_DASHES: tuple[Dash, ...] = ("solid", "dash", "dot")
_MARKERS: tuple[Marker, ...] = ("circle", "hollow", "diamond")


def branches(examined: Examined) -> Chart:
    """Means each two degrees by run in the capture, stations by direction in the reference."""
    panels = []
    for channel in examined.channels:
        rows, left = examined.rows(channel), examined.left(channel)
        noise = examined.model.history[-1].noise_arcsec.get(channel, 0.0)
        if isinstance(rows, CaptureRows):
            panels.append(_runs(rows, left, noise))
        else:
            panels.append(_stations(rows, left, noise))
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
    return Panel(angle_axis(), Axis("R₂ − R₁ less the model", ARCSEC), layers, title)


def _stations(rows: ReferenceRows, left: Float, noise: float) -> Panel:
    side = np.ones(left.size) if rows.direction is None else rows.direction
    degrees = np.mod(np.degrees(rows.target_rad), 360.0)
    layers: list[Curve | Band] = [_noise_band(2.0 * noise)]
    for place, value in enumerate(np.unique(side)):
        inside = side == value
        layers.append(
            Curve(
                degrees[inside],
                left[inside],
                f"direction {signed(float(value), 0)}",
                COLOURS[place % len(COLOURS)],
                kind="points",
                marker=_MARKERS[place % len(_MARKERS)],
                size=4.0,
            )
        )
    title = "Reference run: what the model leaves at each station"
    return Panel(angle_axis(), Axis("error less the model", ARCSEC), layers, title)


def _noise_band(reach: float) -> Band:
    ends = np.array([0.0, 360.0])
    return Band(ends, np.full(2, -reach), np.full(2, reach), "noise of repeats, ±2σ", QUIET, 0.25)
