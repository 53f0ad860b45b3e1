"""Makes the demo's page: one self-contained HTML file."""

from __future__ import annotations

from pathlib import Path

from jinja2 import Environment
from markupsafe import Markup

from arctrue.base.whole_file import write_whole_text
from arctrue.report.charts.error_before_after import error_before_after
from arctrue.report.charts.matplotlib_chart import chart_svg, save_chart
from arctrue.report.charts.orders_before_after import orders_before_after
from arctrue.report.html_templates import html_environment
from arctrue.studies.demo.result import DemoResult


def page_templates() -> Environment:
    """Return the environment for the templates of the demo's pages, with their filters."""
    environment = html_environment()
    environment.filters["signed"] = _signed
    environment.filters["thousands"] = _thousands
    return environment


def write_demo_page(result: DemoResult, file: Path, second_act: str = "") -> None:
    """Render the result and write it with its error figure; make the folder if it does not exist.

    ``second_act``: the name of the second act's page, if there is one.
    """
    environment = page_templates()
    error_figure = error_before_after(result)
    page = environment.get_template("demo.html.j2").render(
        result=result,
        second_act=second_act,
        settings=result.settings,
        count=result.settings.arcsec_per_count,
        before=result.before,
        after=result.after,
        pipeline_clocks=sum(unit.measured_clocks for unit in result.latencies),
        error_figure=Markup(chart_svg(error_figure)),
        spectrum_figure=Markup(chart_svg(orders_before_after(result))),
    )
    write_whole_text(file, page)
    # README.md shows this picture; `make docs` copies it to the documentation.
    save_chart(error_figure, file.parent / "error_before_after.svg")


def _signed(value: float, digits: int = 2) -> str:
    """Return a number as text with a true minus sign."""
    return f"{value:.{digits}f}".replace("-", "−")


def _thousands(value: float) -> str:
    """Return a whole number as text in groups of three digits."""
    return f"{value:,.0f}"
