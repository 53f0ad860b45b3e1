"""A look at a set and a model as one HTML file, and its figures as SVG and PNG."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from markupsafe import Markup

from arctrue.base.whole_file import write_whole_text
from arctrue.measurement.digest import set_digest
from arctrue.report.charts.chart import Chart
from arctrue.report.charts.matplotlib_chart import chart_svg, save_chart
from arctrue.report.examined import Examined
from arctrue.report.html_templates import html_environment
from arctrue.report.ranking import Ranking
from arctrue.report.story import story
from arctrue.report.view import FIGURES, View, chart_of, ranked_conditions

PAGE = "report.html"


def write_look_report(
    examined: Examined,
    ranking: Ranking,
    view: View,
    folder: Path,
    *,
    measurement_set: Path,
    command: str,
) -> list[Path]:
    """Write report.html, which needs no other file, and every figure beside it.

    ``command``: the command line that makes it again. Raises OSError.
    """
    drawn: dict[str, Chart] = {}
    for name in FIGURES:
        chart = chart_of(name, examined, ranking, view)
        if chart is not None:
            drawn[name] = chart
    page = folder / PAGE
    write_whole_text(page, _html(examined, ranking, view, drawn, measurement_set, command))
    paths = [page]
    for name, chart in drawn.items():
        paths += [save_chart(chart, folder / f"{name}.{ending}") for ending in ("svg", "png")]
    return paths


def _html(
    examined: Examined,
    ranking: Ranking,
    view: View,
    drawn: Mapping[str, Chart],
    measurement_set: Path,
    command: str,
) -> str:
    against = examined.conditions.get(view.against) or ranked_conditions(examined, ranking)[0][0]
    return (
        html_environment()
        .get_template("look_report.html.j2")
        .render(
            story=story(examined, ranking, view),
            figures={name: Markup(chart_svg(chart)) for name, chart in drawn.items()},
            against=against.name,
            program=f"arctrue {version('arctrue')}",
            date=f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC",
            digest=set_digest(measurement_set),
            command=command,
            set_name=str(measurement_set),
        )
    )
