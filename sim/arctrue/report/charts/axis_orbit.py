"""Draws the orbit of the axis that the heads measured: the samples (if there are many, only every
second, third, …), and the mean over the turns.
"""

from __future__ import annotations

import numpy as np

from arctrue.calibration.axis_orbit import AxisOrbit
from arctrue.metrology.iso230_7 import BINS, error_motion
from arctrue.report.charts.chart import ARCSEC, COLOURS, QUIET, Axis, Chart, Curve, Panel

_MOST_POINTS = 4000
_BASE = 1.5
"""Radius of the base circle of the polar plot, relative to the largest motion."""


def axis_orbit_chart(orbit: AxisOrbit) -> Chart:
    """Draw the path of the axis on the left, and polar plots of its x and y about a base circle on
    the right. If three heads measured the orbit, draw only the motion that does not repeat in each
    turn."""
    every = max(1, orbit.angle_rad.size // _MOST_POINTS)
    found = [error_motion(orbit.angle_rad, values) for values in (orbit.x_arcsec, orbit.y_arcsec)]
    closed = [np.append(item.mean, item.mean[0]) for item in found]
    if not orbit.has_synchronous:
        place = np.mod(orbit.angle_rad / (2.0 * np.pi), 1.0) * BINS
        x, y = (
            values - item.mean[place.astype(np.int64) % BINS]
            for item, values in zip(found, (orbit.x_arcsec, orbit.y_arcsec), strict=True)
        )
        cloud = Curve(x[::every], y[::every], "every sample", QUIET, "points", size=1.5)
        return Chart(
            "axis_orbit",
            "Asynchronous motion of the axis: displacement divided by the radius of the disc, "
            "minus its mean at each angle. Three heads do not separate this mean from the disc.",
            [Panel(Axis("x", ARCSEC), Axis("y", ARCSEC), [cloud], equal_scales=True)],
            panel_height=4.0,
        )
    path = [
        Curve(
            orbit.x_arcsec[::every], orbit.y_arcsec[::every], "every sample", QUIET, "points",
            size=1.5,
        ),
        Curve(closed[0], closed[1], "synchronous", COLOURS[0]),
    ]  # fmt: skip
    base = _BASE * max(float(np.nanmax(np.abs(values))) for values in closed) or 1.0
    angle = 2.0 * np.pi * (np.arange(BINS + 1) + 0.5) / BINS
    circle = Curve(base * np.cos(angle), base * np.sin(angle), "base circle", QUIET, dash="dot")
    polar = [circle] + [
        Curve((base + values) * np.cos(angle), (base + values) * np.sin(angle), name, colour)
        for values, name, colour in zip(closed, ("x", "y"), COLOURS, strict=False)
    ]
    return Chart(
        "axis_orbit",
        "Orbit of the axis: displacement divided by the radius of the disc, without the circle of "
        "order 1, which an eccentric disc also causes.",
        [
            Panel(Axis("x", ARCSEC), Axis("y", ARCSEC), path, equal_scales=True),
            Panel(
                Axis("synchronous motion, polar", ARCSEC),
                Axis("from the base circle", ARCSEC),
                polar,
                equal_scales=True,
            ),
        ],
        columns=2,
        panel_height=4.0,
    )
