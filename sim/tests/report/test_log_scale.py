"""Tests that the labels of logarithmic axes are numbers, and not the source of matplotlib's
mathematics."""

import re
from pathlib import Path

from matplotlib.figure import Figure

from arctrue.report.log_scale import set_log_y
from arctrue.report.svg import to_svg

SOURCES = Path(__file__).parents[2] / "arctrue"


def _labels(svg: str) -> list[str]:
    return re.findall(r"<text[^>]*>([^<]*)</text>", svg)


def _figure(low: float, high: float, **options: bool) -> Figure:
    figure = Figure()
    axes = figure.subplots()
    axes.plot([0, 1], [low, high])
    set_log_y(axes, **options)
    return figure


def test_powers_of_ten_are_numbers() -> None:
    labels = _labels(to_svg(_figure(0.001, 2000.0)))
    assert {"0.001", "1", "1,000"} <= set(labels)
    assert not any("$" in label or "\\" in label for label in labels)


def test_minor_ticks_get_numbers_when_asked() -> None:
    assert "3" in _labels(to_svg(_figure(1.5, 6.0, label_minor_ticks=True)))
    assert "3" not in _labels(to_svg(_figure(1.5, 6.0)))


def test_no_figure_sets_a_logarithmic_axis_by_itself() -> None:
    alone = [
        file.name
        for file in SOURCES.rglob("*.py")
        if file.name != "log_scale.py"
        and re.search(r"set_[xy]scale\(|semilog[xy]\(|loglog\(", file.read_text("utf-8"))
    ]
    assert not alone, "use arctrue.report.log_scale, so that the labels are numbers"
