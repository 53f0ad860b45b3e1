"""Draws the residual over every condition, and the share of the excess residual that follows each
condition."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from arctrue.base.percent import percent
from arctrue.report.charts.chart import (
    ARCSEC,
    CHANNEL_COLOUR,
    QUIET,
    Axis,
    Bars,
    Chart,
    Curve,
    Level,
    Panel,
    angle_axis,
)
from arctrue.workbench.compare.findings import LEAST_SHARE, Finding
from arctrue.workbench.compare.maps import ResidualMap

_PART_OF_A_TURN_DEG = 180.0
"""Largest span in degrees of a set that covers only a part of the turn; the axis then shows only
this part."""
_COLUMNS = 3
_ROOM = 1.15
"""Factor for the free space above and below the largest mean."""


def residual_maps_chart(maps: Sequence[ResidualMap]) -> Chart:
    """Draw the mean residual in bins of each condition; all panels of a channel have the same
    scale."""
    panels = [
        _panel(item, _reach([other for other in maps if other.channel == channel]))
        for channel in CHANNEL_COLOUR
        for item in maps
        if item.channel == channel
    ]
    words = "Mean residual against each condition."
    return Chart("residual_maps", words, panels, columns=_COLUMNS, panel_height=2.3)


def residual_findings_chart(findings: Sequence[Finding]) -> Chart:
    """Draw two bars for each finding: its own share of the excess (the residual above the noise),
    and the share that stronger findings do not explain."""
    layers = []
    for channel, colour in CHANNEL_COLOUR.items():
        rows = [place for place, item in enumerate(findings) if item.channel == channel]
        if not rows:
            continue
        # The first finding is drawn at the top of the chart.
        place = -np.array(rows, dtype=np.float64)
        alone = np.array([100.0 * findings[row].share for row in rows])
        beyond = np.array([100.0 * findings[row].share_beyond for row in rows])
        layers += [
            Bars(place, alone, f"{channel}: by itself", colour, lying=True, opacity=0.3),
            Bars(place, beyond, "not explained by those above", colour, lying=True, width=0.35),
        ]
    ticks = [(-float(row), f"{item.channel}: {item.follows}") for row, item in enumerate(findings)]
    panel = Panel(
        Axis("share of the excess", "%", reach=(0.0, 100.0)),
        Axis("", ticks=ticks),
        layers,
        "What the residual follows",
    )
    height = 1.2 + 0.3 * len(findings)
    words = "Share of the excess that follows each condition, as `compare` states it."
    return Chart("residual_findings", words, [panel], panel_height=height)


def _reach(items: Sequence[ResidualMap]) -> float:
    """Return half the height of a channel's panels.

    The largest mean of the channel determines the height of all its panels, so that small means
    look flat.
    """
    return _ROOM * max(
        float(np.max(np.abs(item.means_arcsec) + item.standard_errors_arcsec, initial=0.0))
        for item in items
    )


def _panel(item: ResidualMap, reach: float) -> Panel:
    matters = item.excess_share >= LEAST_SHARE
    line = item.goes_round and item.channel == "capture"
    curve = Curve(
        item.centres,
        item.means_arcsec,
        "",
        CHANNEL_COLOUR[item.channel] if matters else QUIET,
        kind="both" if line else "points",
        y_error=item.standard_errors_arcsec,
        width=0.9,
        size=3.0,
    )
    title = f"{percent(item.share, 1)} of the variance, chance {percent(item.null_share, 1)}"
    if not matters:
        title = f"less than {percent(LEAST_SHARE)} beyond chance"
    y = Axis(f"{item.channel}, mean", ARCSEC, reach=(-reach, reach) if reach > 0.0 else None)
    return Panel(_axis(item), y, [Level(0.0, dash="solid"), curve], title)


def _axis(item: ResidualMap) -> Axis:
    if item.goes_round and np.ptp(item.centres) > _PART_OF_A_TURN_DEG:
        return angle_axis(item.condition)
    ticks = None
    if item.unit == "1" and np.array_equal(item.centres, np.rint(item.centres)):
        ticks = [(float(value), f"{value:.0f}".replace("-", "−")) for value in item.centres]
    return Axis(item.condition, item.unit, ticks=ticks)
