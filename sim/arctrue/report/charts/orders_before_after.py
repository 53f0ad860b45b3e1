"""Draws the amplitudes of orders 1 to 24 of the demo's output, before and after compensation."""

from __future__ import annotations

import numpy as np

from arctrue.report.charts.chart import QUIET, Axis, Bars, Chart, Layer, Level, Panel
from arctrue.report.svg import AFTER, BEFORE
from arctrue.studies.demo.result import DemoResult

_ORDERS = 24
_FLOOR_COUNTS = 1e-3
"""Lower end of the logarithmic axis."""


def orders_before_after(result: DemoResult) -> Chart:
    """Draw two bars for each order on a logarithmic axis, before and after, and the limit that
    applies to one order."""
    limit, count = result.settings.order_limit_counts, result.settings.arcsec_per_count
    layers: list[Layer] = []
    for turn, shift, colour, name in (
        (result.before, -0.2, BEFORE, "before"),
        (result.after, 0.2, AFTER, "after"),
    ):
        amplitude_counts = turn.amplitude_arcsec[:_ORDERS] / count
        layers.append(
            Bars(
                np.arange(1, _ORDERS + 1) + shift,
                np.maximum(amplitude_counts, _FLOOR_COUNTS) - _FLOOR_COUNTS,
                name,
                colour,
                base=_FLOOR_COUNTS,
                width=0.38,
            )
        )
    layers.append(Level(limit, f"limit {limit:g} count an order", QUIET))
    x = Axis(
        "order n, cycles a turn",
        reach=(0.4, _ORDERS + 0.6),
        ticks=[(float(order), str(order)) for order in range(1, _ORDERS + 1)],
    )
    top = 2.0 * float(result.before.amplitude_arcsec.max()) / count
    y = Axis("amplitude", "counts", logarithmic=True, reach=(_FLOOR_COUNTS, top))
    words = f"Amplitude of orders 1 to {_ORDERS}, before and after."
    return Chart(
        "orders_before_after", words, [Panel(x, y, layers, "Orders of the error")], panel_height=3.1
    )
