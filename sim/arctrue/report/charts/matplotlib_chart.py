"""Draws a chart with matplotlib: as SVG for a page, and as PNG or SVG files."""

from __future__ import annotations

import math
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from arctrue.base.whole_file import whole_file
from arctrue.report.charts.chart import (
    SYMBOLS,
    Axis,
    Band,
    Bars,
    Chart,
    Curve,
    HeatMap,
    Layer,
    Level,
    Panel,
)
from arctrue.report.charts.tick_names import tick_lines, tick_names
from arctrue.report.log_scale import set_log_x, set_log_y
from arctrue.report.svg import GRID, INK, MUTED, house_style, to_svg

_STYLE_IS_GLOBAL = threading.RLock()
"""Lock for matplotlib's settings, which all threads share; the page draws in several threads."""
_WIDTH = 9.6
_DASHES: dict[str, Any] = {"solid": "-", "dash": (0, (4, 3)), "dot": ":"}
_MARKERS = {"circle": "o", "square": "s", "diamond": "D", "hollow": "s"}
_PAPER = {
    "#ffffff": "paper",
    INK: "ink",
    MUTED: "muted",
    GRID: "grid",
    "#b5bdc7": "axis",
    "#000000": "ink",
}
"""Names of the house style's colours in the page's style sheet, by colour."""
_DECADE = 12.0
"""Ratio of the ends of a logarithmic axis, below which the axis also labels its minor ticks."""
_TITLE_POINTS, _SMALL_POINTS = {1: 11.0, 2: 10.0}, 8.5
"""Font sizes of titles by the number of panels per row, and the font size of small text."""
_BESIDE_INCHES, _LETTER_INCHES = 0.8, 0.068
"""Width left of a panel, and width of a letter in a font of 8 points, inches."""
_LEGEND_COLUMNS, _NARROW_COLUMNS = 4, 3


def chart_svg(chart: Chart) -> str:
    """Return the chart as an ``<svg>`` element that scales with the page and has a text
    description.

    The colours of ink, grid and background follow the page, which may be dark or light.
    """
    with _STYLE_IS_GLOBAL:
        svg = to_svg(chart_figure(chart))
    for colour, name in _PAPER.items():
        svg = svg.replace(f": {colour}", f": var(--{name}, {colour})")
    head, rest = svg.split(">", 1)
    return f'{head} role="img" aria-label="{_attribute(chart.words)}">{rest}'


def save_chart(chart: Chart, path: Path) -> Path:
    """Write the chart to a file in the format of the file name's ending. Raises OSError."""
    metadata = {"Date": None} if path.suffix == ".svg" else None
    with _STYLE_IS_GLOBAL, house_style(), whole_file(path) as unfinished:
        chart_figure(chart).savefig(unfinished, dpi=130, metadata=metadata)
    return path


def save_charts(charts: Mapping[str, Chart], folder: Path) -> list[Path]:
    """Write each chart to a PNG file that has the chart's name. Raises OSError."""
    return [save_chart(chart, folder / f"{name}.png") for name, chart in charts.items()]


def chart_figure(chart: Chart) -> Figure:
    """Draw the chart as a figure of matplotlib."""
    with house_style():
        columns = min(chart.columns, max(len(chart.panels), 1))
        rows = max(-(-len(chart.panels) // columns), 1)
        figure = Figure(figsize=(_WIDTH, chart.panel_height * rows + 0.5), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots(rows, columns, squeeze=False).ravel()
        for unused in axes[len(chart.panels) :]:
            unused.set_visible(False)
        for one, panel in zip(axes, chart.panels, strict=False):
            _draw(figure, one, panel, columns)
        return figure


def _draw(figure: Figure, axes: Axes, panel: Panel, columns: int) -> None:
    for order, layer in enumerate(panel.layers):
        _draw_layer(figure, axes, layer, order + 2)
    if panel.title:
        axes.set_title(panel.title, fontsize=_TITLE_POINTS.get(columns, _SMALL_POINTS))
    letters = (_WIDTH / columns - _BESIDE_INCHES) / _LETTER_INCHES
    _dress(axes, panel.x, letters, horizontal=True)
    _dress(axes, panel.y, math.inf, horizontal=False)
    if any(isinstance(layer, HeatMap) for layer in panel.layers):
        axes.grid(visible=False)
    if panel.equal_scales:
        axes.set_aspect("equal", adjustable="datalim")
    if panel.y.also is not None:
        _second_unit(axes, panel.y, panel.y.also)
    handles, names = axes.get_legend_handles_labels()
    if names:
        _legend(axes, len(handles), _LEGEND_COLUMNS if columns == 1 else _NARROW_COLUMNS)


def _second_unit(axes: Axes, axis: Axis, also: tuple[str, float]) -> None:
    unit, factor = also
    right = axes.secondary_yaxis(
        "right",
        functions=(
            lambda value: np.asarray(value) * factor,
            lambda value: np.asarray(value) / factor,
        ),
    )
    right.set_ylabel(f"{axis.label}, {SYMBOLS.get(unit, unit)}")
    right.spines["right"].set_visible(True)


def _legend(axes: Axes, entries: int, columns: int) -> None:
    """Place the legend inside the panel above the data; the function adds room there, because the
    data may fill every corner."""
    rows = -(-entries // columns)
    low, high = axes.get_ylim()
    if axes.get_yscale() == "log":
        axes.set_ylim(low, high * (high / low) ** (0.06 + 0.08 * rows))
    else:
        axes.set_ylim(low, high + (0.05 + 0.08 * rows) * (high - low))
    axes.legend(fontsize=8, ncols=columns, loc="upper right", borderaxespad=0.2, frameon=False)


def _dress(axes: Axes, axis: Axis, letters: float, *, horizontal: bool) -> None:
    side = axes.xaxis if horizontal else axes.yaxis
    side.set_label_text(axis.text)
    if axis.logarithmic:
        low, high = axis.reach or (1.0, _DECADE)
        (set_log_x if horizontal else set_log_y)(axes, label_minor_ticks=high < _DECADE * low)
        side.set_tick_params(which="both", labelsize=8)
    if axis.ticks is not None:
        ticks = tick_names(axis, letters) if horizontal else list(axis.ticks)
        side.set_ticks([place for place, _ in ticks], [name for _, name in ticks])
        if tick_lines(ticks) > 1:
            side.set_tick_params(labelsize=8)
    if axis.reach is not None:
        (axes.set_xlim if horizontal else axes.set_ylim)(*axis.reach)


def _draw_layer(figure: Figure, axes: Axes, layer: Layer, order: int) -> None:
    name = getattr(layer, "name", "") or "_nolegend_"
    if isinstance(layer, Curve):
        _draw_curve(axes, layer, name, order)
    elif isinstance(layer, Band):
        axes.fill_between(
            layer.x,
            layer.low,
            layer.high,
            color=layer.colour,
            alpha=layer.opacity,
            linewidth=0.9 if layer.opacity == 1.0 else 0.0,
            label=name,
            zorder=order,
        )
    elif isinstance(layer, Bars):
        shape: dict[str, Any] = {
            "color": layer.colour,
            "alpha": layer.opacity,
            "label": name,
            "zorder": order,
        }
        if layer.lying:
            bars = axes.barh(layer.place, layer.length, layer.width, left=layer.base, **shape)
        else:
            bars = axes.bar(layer.place, layer.length, layer.width, bottom=layer.base, **shape)
        if layer.labels:
            axes.bar_label(bars, list(layer.labels), padding=4, fontsize=8)
    elif isinstance(layer, Level):
        axes.axhline(
            layer.value,
            color=layer.colour,
            linestyle=_DASHES[layer.dash],
            linewidth=1.1,
            label=name,
            zorder=order,
        )
    else:
        _draw_heat_map(figure, axes, layer)


def _draw_curve(axes: Axes, layer: Curve, name: str, order: int) -> None:
    hollow = layer.marker == "hollow"
    axes.errorbar(
        layer.x,
        layer.y,
        layer.y_error,
        color=layer.colour,
        linestyle="none" if layer.kind == "points" else _DASHES[layer.dash],
        linewidth=layer.width,
        marker="none" if layer.kind == "line" else _MARKERS[layer.marker],
        markersize=layer.size,
        markerfacecolor="none" if hollow else layer.colour,
        markeredgewidth=1.2 if hollow else 0.0,
        elinewidth=0.9,
        label=name,
        zorder=order,
    )
    for x, y, text in zip(layer.x, layer.y, layer.texts, strict=False):
        if np.isfinite(y):
            axes.annotate(text, (x, y), (0, 8), textcoords="offset points", ha="center", fontsize=8)


def _draw_heat_map(figure: Figure, axes: Axes, layer: HeatMap) -> None:
    reach = float(np.nanmax(np.abs(layer.values), initial=0.0)) or 1.0
    mesh = axes.pcolormesh(
        layer.x,
        layer.y,
        layer.values,
        cmap="PuOr",
        vmin=-reach,
        vmax=reach,
        shading="nearest",
        rasterized=True,
    )
    bar = figure.colorbar(mesh, ax=axes, pad=0.01)
    bar.set_label(f"{layer.label}, {SYMBOLS.get(layer.unit, layer.unit)}")


def _attribute(text: str) -> str:
    return text.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
