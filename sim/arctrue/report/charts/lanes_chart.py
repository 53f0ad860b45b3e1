"""Draws the correction by the gateware's lanes (one lane per order): the amplitude of each lane,
and the error before and after the correction.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from arctrue.report.charts.angle_window import AngleWindow
from arctrue.report.charts.chart import (
    ARCSEC,
    COLOURS,
    Axis,
    Bars,
    Chart,
    Curve,
    Panel,
)


def lanes_chart(
    orders: Sequence[int],
    amplitudes_arcsec: Sequence[float],
    at_reference: Sequence[Sequence[float]] | None,
) -> Chart:
    """Draw the amplitudes of the lanes and the error before and after the correction.

    ``at_reference``: targets in degrees, then errors before and after the correction, with a value
    for each row of the reference.
    """
    place = np.arange(len(orders), dtype=np.float64)
    ticks = [(float(number), str(order)) for number, order in enumerate(orders)]
    panels = [
        Panel(
            Axis("order, cycles a turn", ticks=ticks),
            Axis("amplitude of the lane", ARCSEC),
            [Bars(place, np.array(amplitudes_arcsec, dtype=np.float64))],
            "Lanes",
        )
    ]
    if at_reference is not None:
        target, before, after = (_array(values) for values in at_reference)
        window = AngleWindow.over(np.radians(target))
        degrees = window.degrees(np.radians(target))
        panels.append(
            Panel(
                window.axis(),
                Axis("error against the reference", ARCSEC),
                [
                    Curve(degrees, before, "as measured", COLOURS[1], kind="points", size=4.0),
                    Curve(
                        degrees, after, "with the lanes", COLOURS[0], kind="points",
                        marker="diamond", size=4.0,
                    ),
                ],
                "Reference run through the bit-true gateware",
            )
        )  # fmt: skip
    words = f"{len(orders)} lanes; the largest is {max(amplitudes_arcsec, default=0.0):.3f}″."
    return Chart("lanes", words, panels)


def _array(values: Sequence[float]) -> NDArray[np.float64]:
    return np.array(values, dtype=np.float64)
