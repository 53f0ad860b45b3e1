"""Describes the history of one machine as sentences, tables and an HTML page."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Any

from markupsafe import Markup

from arctrue.base.extras import needs_extras
from arctrue.base.figures import figure, probability, with_uncertainty
from arctrue.base.whole_file import write_whole_text
from arctrue.metrology.life.change import FEWEST_SETS, Change
from arctrue.metrology.life.forecast import Forecast
from arctrue.metrology.life.history import LifeHistory
from arctrue.report.charts.life_chart import day_name, life_chart
from arctrue.report.html_templates import html_environment

PAGE = "life.html"


def change_sentence(change: Change) -> str:
    """Return one sentence that states what changed, by how much and when."""
    what = "changed in one step" if change.kind == "step" else "has drifted"
    size = with_uncertainty(change.size, change.u, change.series.unit)
    since = "on" if change.kind == "step" else "since"
    return (
        f"{change.series.name} {what} by {size} {since} about {day_name(change.day)} (95 %: "
        f"{day_name(change.earliest_day)} to {day_name(change.latest_day)}; p "
        f"{probability(change.p_value)})."
    )


def forecast_sentence(found: Forecast, horizon_days: float) -> str:
    """Return one sentence that states when the limit is passed."""
    name, limit = found.series.name, with_uncertainty(found.limit, 0.0, found.series.unit)
    if found.passed:
        return f"ALARM: {name} has passed its limit of {limit}."
    if not found.changed:
        return f"{name}: no change found, so no forecast for the limit {limit}."
    early, late = day_name(found.earliest_day), day_name(found.latest_day)
    alarm = "ALARM: " if found.alarm(horizon_days) else ""
    if found.earliest_day == float("inf"):
        return f"{name} changed, but does not approach its limit of {limit}."
    middle = "probably never" if found.day == float("inf") else f"about {day_name(found.day)}"
    ends = f"not before {early}" if late == "–" else f"95 %: {early} to {late}"
    return f"{alarm}{name} passes its limit of {limit} {middle} ({ends})."


def calibration_sentence(history: LifeHistory) -> str:
    """Return one sentence that states which calibrations are no longer valid, and since when."""
    broken = [one for one in history.calibrations if one.broken_by]
    if len(history.machine.sets) < FEWEST_SETS:
        return (
            f"{len(history.machine.sets)} sets are too few to test for a change; expected "
            f"{FEWEST_SETS} or more."
        )
    if not broken:
        return "Every calibration from these sets is still valid: no change was found."
    last = broken[-1]
    changes = dict.fromkeys(change for one in broken for change in one.broken_by)
    names = ", ".join(dict.fromkeys(change.series.name for change in changes))
    since = day_name(min(change.day for change in changes))
    return (
        f"Calibrations from sets until {day_name(last.of.day)} no longer hold; {names} changed, "
        f"first about {since}."
    )


def life_sentences(history: LifeHistory) -> list[str]:
    """Return all findings as sentences: first the forecasts, those with the earliest day first."""
    forecasts = sorted(history.forecasts, key=lambda one: one.earliest_day)
    return [
        *(forecast_sentence(one, history.horizon_days) for one in forecasts),
        calibration_sentence(history),
        *map(change_sentence, history.changes),
        f"The probability of a false finding in this run is at most "
        f"{figure(100.0 * history.look_probability, 2)} %; with one run after each set, "
        f"{history.false_alarms_a_year:g} false findings per year are permitted.",
    ]


def life_data(history: LifeHistory) -> dict[str, Any]:
    """Return the content of the file that ``--json`` writes."""
    return {
        "schema": 1,
        "program": f"arctrue {version('arctrue')}",
        "model": history.machine.model.names(),
        "false_alarms_a_year": history.false_alarms_a_year,
        "false_alarm_probability": history.look_probability,
        "horizon_days": history.horizon_days,
        "sets": [
            {"name": one.name, "date": one.date.isoformat(), "sha256": one.sha256}
            for one in history.machine.sets
        ],
        "refused": [{"name": one.name, "reason": one.reason} for one in history.machine.refused],
        "series": [
            {
                "name": one.name,
                "unit": one.unit,
                "size": one.size.tolist(),
                "components": one.values.tolist(),
                "u": one.u.tolist(),
            }
            for one in history.series
        ],
        "changes": [
            {
                "name": one.series.name,
                "kind": one.kind,
                "date": day_name(one.day),
                "earliest": day_name(one.earliest_day),
                "latest": day_name(one.latest_day),
                "size": one.size,
                "u": one.u,
                "unit": one.series.unit,
                "p_value": one.p_value,
            }
            for one in history.changes
        ],
        "forecasts": [
            {
                "name": one.series.name,
                "limit": one.limit,
                "unit": one.series.unit,
                "passed": one.passed,
                "alarm": one.alarm(history.horizon_days),
                "date": _date_or_none(one.day),
                "earliest": _date_or_none(one.earliest_day),
                "latest": _date_or_none(one.latest_day),
            }
            for one in history.forecasts
        ],
        "calibrations": [
            {
                "set": one.of.name,
                "sha256": one.of.sha256,
                "date": one.of.date.isoformat(),
                "holds": not one.broken_by,
                "since": _date_or_none(one.broken_since_day),
                "broken_by": [change.series.name for change in one.broken_by],
            }
            for one in history.calibrations
        ],
    }


def _date_or_none(day: float) -> str | None:
    name = day_name(day)
    return None if name == "–" else name


def write_life_page(history: LifeHistory, folder: Path, *, command: str) -> Path:
    """Write life.html, which needs no other file. ``command``: the command line that makes the page
    again.

    Raises OSError, and MissingExtraError without matplotlib.
    """
    # Sentences and data need no matplotlib, which the extra page installs.
    with needs_extras():
        from arctrue.report.charts.matplotlib_chart import chart_svg

    rows = [
        (
            one.name,
            with_uncertainty(float(one.size[0]), float(one.u[0]), one.unit),
            with_uncertainty(float(one.size[-1]), float(one.u[-1]), one.unit),
            ", ".join(day_name(change.day) for change in history.changes_of(one)) or "–",
        )
        for one in history.series
    ]
    page = html_environment().get_template("life.html.j2").render(
        sentences=life_sentences(history),
        alarm=bool(history.alarms),
        chart=Markup(chart_svg(life_chart(history))),
        rows=rows,
        sets=[(one.name, f"{one.date:%Y-%m-%d %H:%M}") for one in history.machine.sets],
        refused=[(one.name, one.reason) for one in history.machine.refused],
        program=f"arctrue {version('arctrue')}",
        command=command,
    )  # fmt: skip
    path = folder / PAGE
    write_whole_text(path, page)
    return path
