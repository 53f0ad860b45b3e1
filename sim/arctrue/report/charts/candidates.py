"""Draws the evidence for each candidate effect: ΔBIC as bars."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from arctrue.report.charts.chart import COLOURS, QUIET, Axis, Bars, Chart, Curve, Layer, Panel
from arctrue.workbench.diagnose.diagnosis import Diagnosis

Float = NDArray[np.float64]

_MOST = 10
LINEAR_TO = 10.0
"""Largest |ΔBIC| on the linear part of the axis (odds of 150 to 1); beyond it the axis is
logarithmic."""
_ROOM = 0.4
"""Space for the numbers next to the longest bars, in decades of the axis."""


def candidates_chart(result: Diagnosis) -> Chart:
    """Draw ΔBIC of the leading candidates; colours mark the named effect and the effects that
    belong to its class."""
    shown = result.candidates[:_MOST]
    named = None if result.named is None else result.named.name

    def is_named(name: str) -> bool:
        return name == named

    def of_the_class(name: str) -> bool:
        return name != named and name in result.effect_class

    def other(name: str) -> bool:
        return name != named and name not in result.effect_class

    groups: tuple[tuple[str, str, Callable[[str], bool]], ...] = (
        ("named", COLOURS[2], is_named),
        ("of the class that the data do not separate", COLOURS[1], of_the_class),
        ("other candidates", COLOURS[0], other),
    )
    layers: list[Layer] = []
    for label, colour, belongs in groups:
        rows = [row for row, item in enumerate(shown) if belongs(item.name)]
        if rows:
            value = np.array([shown[row].delta_bic for row in rows])
            texts = [f"{one:,.0f}".replace("-", "−") for one in value]
            # The first candidate is drawn at the top of the chart.
            place = -np.array(rows, dtype=np.float64)
            layers.append(Bars(place, along(value), label, colour, lying=True, labels=texts))
    if shown:
        ends = np.array([0.5, 0.5 - len(shown)])
        layers.append(Curve(np.zeros(2), ends, "", QUIET, width=0.8))
    places = along(np.array([item.delta_bic for item in shown] or [0.0]))
    low, high = min(float(places.min()), 0.0), max(float(places.max()), 0.0)
    x = Axis(
        f"ΔBIC: evidence minus the cost of parameters and search (linear to ±{LINEAR_TO:g})",
        reach=(low - _ROOM, high + _ROOM),
        ticks=_ticks(low, high),
    )
    names = [(-float(row), item.name.replace("_", " ")) for row, item in enumerate(shown)]
    panel = Panel(x, Axis("", ticks=names), layers, _verdict(result))
    words = f"Evidence for each candidate. {_verdict(result)}."
    return Chart("candidates", words, [panel], panel_height=1.4 + 0.34 * max(len(shown), 1))


def along(delta_bic: Float) -> Float:
    """Return the position of each ΔBIC on the axis: x/10 up to ±10, then ±(1 + log₁₀(|x|/10))."""
    size = np.abs(delta_bic) / LINEAR_TO
    return np.asarray(
        np.sign(delta_bic) * np.where(size > 1.0, 1.0 + np.log10(np.maximum(size, 1.0)), size)
    )


def _ticks(low: float, high: float) -> list[tuple[float, str]]:
    """Return the ticks 0, ±10, ±100, … within the range of the bars."""
    found = [(0.0, "0")]
    for place in range(1, int(np.ceil(max(-low, high))) + 1):
        name = f"{LINEAR_TO * 10.0 ** (place - 1):,.0f}"
        found += [(float(place), name)] if place <= high + _ROOM else []
        found += [(-float(place), f"−{name}")] if -place >= low - _ROOM else []
    return sorted(found)


def _verdict(result: Diagnosis) -> str:
    if result.named is not None:
        return f"Verdict: named, {result.named.name}"
    if result.verdict == "ambiguous":
        return f"Verdict: ambiguous between {', '.join(result.effect_class)}"
    return f"Verdict: {result.verdict}"
