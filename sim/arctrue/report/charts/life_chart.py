"""Draws the sizes of effects over months, with their changes, limits and forecasts."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta

import numpy as np

from arctrue.metrology.life.forecast import Forecast
from arctrue.metrology.life.history import LifeHistory
from arctrue.metrology.life.series import Series
from arctrue.report.charts.chart import COLOURS, QUIET, Axis, Chart, Curve, Layer, Level, Panel

MOST_PANELS = 8
TICKS = 4
COVERAGE = 2.0
"""Length of an error bar to one side, in standard uncertainties."""
AHEAD = 0.5
"""Largest length of a drawn forecast, as a share of the measured time."""
MARGIN = 0.03


def day_name(day: float) -> str:
    """Return a day, counted from 1970, as a date such as ``2026-03-12``; return a dash for an
    infinite day."""
    if not np.isfinite(day):
        return "–"
    return f"{datetime(1970, 1, 1, tzinfo=UTC) + timedelta(days=day):%Y-%m-%d}"


def shown_series(history: LifeHistory) -> list[Series]:
    """Return at most ``MOST_PANELS`` series: those with a limit first, then those that changed,
    then those with the largest ratio of size to uncertainty."""
    limited = {one.series.name for one in history.forecasts}
    changed = {one.series.name for one in history.changes}
    ranked = sorted(
        history.series,
        key=lambda one: (
            one.name not in limited,
            one.name not in changed,
            -float(np.median(one.size / one.u)),
        ),
    )
    return ranked[:MOST_PANELS]


def life_chart(history: LifeHistory) -> Chart:
    """Draw a panel for each series of :func:`shown_series`."""
    forecasts = {one.series.name: one for one in history.forecasts}
    panels = [
        _panel(history, series, forecasts.get(series.name)) for series in shown_series(history)
    ]
    words = f"Sizes of {len(panels)} parameters over {len(history.machine.sets)} sets"
    if history.changes:
        words += "; changed: " + ", ".join(
            f"{one.series.name} on {day_name(one.day)}" for one in history.changes
        )
    return Chart("life", f"{words}.", panels, columns=2 if len(panels) > 1 else 1)


def _panel(history: LifeHistory, series: Series, found: Forecast | None) -> Panel:
    days, size = series.days, series.size
    first, last = float(days[0]), float(days[-1])
    span = max(last - first, 1.0)
    end = last
    layers: list[Layer] = [
        Curve(days, size, "size", COLOURS[0], kind="points", y_error=COVERAGE * series.u, size=4.0)
    ]
    top = float(np.max(size + COVERAGE * series.u))
    if found is not None:
        layers.append(Level(found.limit, "limit", COLOURS[1]))
        top = max(top, found.limit)
        end = min(found.day, last + AHEAD * span) if np.isfinite(found.day) else last
        if last < found.day <= last + AHEAD * span:
            now = float(size[-1])
            layers.append(
                Curve(
                    np.array([last, found.day]), np.array([now, found.limit]), "forecast",
                    COLOURS[1], dash="dash",
                )
            )  # fmt: skip
    for number, change in enumerate(history.changes_of(series)):
        layers.append(
            Curve(
                np.array([change.day, change.day]), np.array([0.0, top]),
                "change" if number == 0 else "", QUIET, dash="dot",
            )
        )  # fmt: skip
    # A single set has one date and an axis of one day.
    places = np.linspace(first, end, TICKS) if end > first else [first]
    ticks = [(float(day), day_name(day)) for day in places]
    margin = MARGIN * (end - first) or span
    return Panel(
        Axis("date of the set", ticks=ticks, reach=(first - margin, end + margin)),
        Axis("size", series.unit),
        layers,
        series.name,
    )
