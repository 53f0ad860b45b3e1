"""Draws the picture of ``arctrue calibrate``: the error before and after, and the orders with their
limits."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.calibration.calibration import Calibration
from arctrue.calibration.comparison import ReferenceComparison, extent
from arctrue.calibration.selection import significance_factor
from arctrue.report.charts.chart import (
    ARCSEC,
    QUIET,
    Axis,
    Band,
    Bars,
    Chart,
    Curve,
    Layer,
    Marker,
    Panel,
    angle_axis,
    signed,
)
from arctrue.report.svg import AFTER, BEFORE, INK

Float = NDArray[np.float64]

_CURVE_POINTS = 1441
"""Number of points of the fitted error over the turn, four per degree."""
_FLOOR_ARCSEC = 1e-5
"""Lowest start of the logarithmic axis of amplitudes."""
_ROOM = 3.0
"""Factor by which the axis extends below the smallest standard uncertainty and above the largest
amplitude."""
_DIRECTIONS: tuple[tuple[int, str, str, Marker], ...] = (
    (1, "up", AFTER, "circle"),
    (-1, "down", QUIET, "diamond"),
)


def calibration_chart(calibration: Calibration, title: str) -> Chart:
    """Draw the fitted error, the error that remains at the targets of the reference run, and the
    amplitudes of the orders."""
    degrees = np.linspace(0.0, 360.0, _CURVE_POINTS)
    fitted = calibration.estimate.error_arcsec(np.radians(degrees))
    layers: list[Layer] = [Curve(degrees, fitted, "from the two heads", BEFORE, width=1.2)]
    compared = calibration.comparison
    if compared is not None:
        layers.append(_before(compared, INK))
    panels = [_error_panel(layers, title)]
    if compared is not None:
        panels.append(_after(compared))
    panels.append(_orders(calibration))
    words = f"Error of head 1 and amplitudes of its orders: {title}."
    return Chart("calibration", words, panels)


def reference_calibration_chart(comparison: ReferenceComparison, title: str) -> Chart:
    """Draw the errors of a reference run before and after the gateware's correction."""
    panels = [_error_panel([_before(comparison, BEFORE)], title), _after(comparison)]
    words = f"Error of head 1 at the reference run's targets, before and after: {title}."
    return Chart("calibration", words, panels)


def _error_panel(layers: list[Layer], title: str) -> Panel:
    return Panel(angle_axis(), Axis("error", ARCSEC), layers, f"{title}: error of head 1")


def _before(comparison: ReferenceComparison, colour: str) -> Curve:
    place = np.remainder(comparison.target_deg, 360.0)
    return Curve(place, comparison.before_arcsec, "reference run", colour, kind="points", size=2.0)


def _after(comparison: ReferenceComparison) -> Panel:
    place = np.remainder(comparison.target_deg, 360.0)
    direction = comparison.direction
    layers: list[Layer] = []
    if comparison.noise is not None:
        low, high = np.full(2, comparison.noise.lowest), np.full(2, comparison.noise.highest)
        layers.append(Band(np.array([0.0, 360.0]), low, high, "scatter of the repeats", QUIET))
    for sign, name, colour, marker in _DIRECTIONS:
        rows = np.full(place.size, sign == 1) if direction is None else direction == sign
        if rows.any():
            layers.append(
                Curve(
                    place[rows],
                    comparison.after_arcsec[rows],
                    "after" if direction is None else name,
                    colour,
                    kind="points",
                    marker=marker,
                    size=3.0,
                )
            )
    after = extent(comparison.after_arcsec)
    title = f"After, through the gateware: {signed(after.lowest, 2)} to {signed(after.highest, 2)}″"
    return Panel(angle_axis(), Axis("error", ARCSEC), layers, title)


def _orders(calibration: Calibration) -> Panel:
    estimate = calibration.estimate
    applied = np.array([verdict.applied for verdict in calibration.verdicts], dtype=bool)
    seen = np.isfinite(estimate.noise_gain)
    lowest = float(estimate.u_component_arcsec[seen].min(initial=1e-3))
    floor = max(lowest / _ROOM, _FLOOR_ARCSEC)
    orders = estimate.orders.astype(np.float64)
    amplitude = np.maximum(estimate.amplitude_arcsec, floor)
    layers: list[Layer] = [
        Bars(orders[chosen], amplitude[chosen] - floor, name, colour, base=floor)
        for chosen, colour, name in (
            (applied, AFTER, "applied"),
            (~applied & seen, QUIET, "not applied"),
        )
        if chosen.any()
    ]
    factor = significance_factor(int(np.count_nonzero(seen)))
    limit = np.where(seen, factor * estimate.u_component_arcsec, np.nan)
    layers.append(Curve(orders, limit, f"{factor:.1f} × standard uncertainty", INK, dash="dash"))
    top = max(float(amplitude.max()) * _ROOM, 1e-3)
    y = Axis("amplitude", ARCSEC, logarithmic=True, reach=(floor, top))
    return Panel(Axis("order n, cycles a turn"), y, layers, "Orders of the error")
