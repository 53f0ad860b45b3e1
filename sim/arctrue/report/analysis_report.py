"""Writes an analysis as one HTML file, and its figures as SVG and PNG."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from markupsafe import Markup

from arctrue.base.whole_file import write_whole_text
from arctrue.measurement.digest import set_digest
from arctrue.report.analysis import Analysis
from arctrue.report.charts.chart import Chart
from arctrue.report.charts.matplotlib_chart import chart_svg, save_chart
from arctrue.report.display import FIGURES, DisplaySettings, chart_of, ranked_conditions
from arctrue.report.html_templates import html_environment
from arctrue.report.ranking import Ranking
from arctrue.report.sections import report_sections

PAGE = "report.html"


def write_analysis_report(
    analysis: Analysis,
    ranking: Ranking,
    display: DisplaySettings,
    folder: Path,
    *,
    measurement_set: Path,
    command: str,
) -> list[Path]:
    """Write report.html, which needs no other file, and every figure as a file next to it.

    ``command``: the command line that repeats the report. Raises OSError.
    """
    drawn: dict[str, Chart] = {}
    for name in FIGURES:
        chart = chart_of(name, analysis, ranking, display)
        if chart is not None:
            drawn[name] = chart
    page = folder / PAGE
    write_whole_text(page, _html(analysis, ranking, display, drawn, measurement_set, command))
    paths = [page]
    for name, chart in drawn.items():
        paths += [save_chart(chart, folder / f"{name}.{ending}") for ending in ("svg", "png")]
    return paths


def _html(
    analysis: Analysis,
    ranking: Ranking,
    display: DisplaySettings,
    drawn: Mapping[str, Chart],
    measurement_set: Path,
    command: str,
) -> str:
    against = analysis.conditions.get(display.against) or ranked_conditions(analysis, ranking)[0][0]
    return (
        html_environment()
        .get_template("analysis_report.html.j2")
        .render(
            sections=report_sections(analysis, ranking, display),
            figures={name: Markup(chart_svg(chart)) for name, chart in drawn.items()},
            against=against.name,
            program=f"arctrue {version('arctrue')}",
            date=f"{datetime.now(UTC):%Y-%m-%d %H:%M} UTC",
            digest=set_digest(measurement_set),
            command=command,
            set_name=str(measurement_set),
        )
    )
