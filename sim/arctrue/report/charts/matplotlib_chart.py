"""A chart as SVG for a page and as PNG or SVG files, drawn by matplotlib."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

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
from arctrue.report.svg import GRID, INK, MUTED, house_style, to_svg
from arctrue.whole_file import whole_file

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
"""Colours of the house style, and the page's name for each."""
_DECADE = 12.0
"""A logarithmic axis of less than this ratio names its minor ticks too."""
_LEGEND_COLUMNS = 4


def chart_svg(chart: Chart) -> str:
    """The chart as an ``<svg>`` element that scales with the page and says what it shows.

    Ink and grid are those of the page, dark or light; the ground is the page's.
    """
    svg = to_svg(chart_figure(chart))
    for colour, name in _PAPER.items():
        svg = svg.replace(f": {colour}", f": var(--{name}, {colour})")
    head, rest = svg.split(">", 1)
    return f'{head} role="img" aria-label="{_attribute(chart.words)}">{rest}'


def save_chart(chart: Chart, path: Path) -> Path:
    """Write a picture; its kind by the ending of ``path``. Raises OSError."""
    figure = chart_figure(chart)
    metadata = {"Date": None} if path.suffix == ".svg" else None
    with house_style(), whole_file(path) as unfinished:
        figure.savefig(unfinished, dpi=130, metadata=metadata)
    return path


def chart_figure(chart: Chart) -> Figure:
    """The figure of matplotlib."""
    with house_style():
        count = max(len(chart.panels), 1)
        height = chart.panel_height * (1 if chart.beside else count) + 0.5
        figure = Figure(figsize=(_WIDTH, height), layout="constrained")
        FigureCanvasAgg(figure)
        shape = (1, count) if chart.beside else (count, 1)
        axes = figure.subplots(*shape, squeeze=False).ravel()
        for one, panel in zip(axes, chart.panels, strict=False):
            _draw(figure, one, panel)
        return figure


def _draw(figure: Figure, axes: Axes, panel: Panel) -> None:
    for order, layer in enumerate(panel.layers):
        _draw_layer(figure, axes, layer, order + 2)
    if panel.title:
        axes.set_title(panel.title)
    _dress(axes, panel.x, horizontal=True)
    _dress(axes, panel.y, horizontal=False)
    if any(isinstance(layer, HeatMap) for layer in panel.layers):
        axes.grid(visible=False)
    handles, names = axes.get_legend_handles_labels()
    if names:
        _legend(axes, len(handles))


def _legend(axes: Axes, entries: int) -> None:
    """Above what was measured: no corner of a picture is sure to be free."""
    rows = -(-entries // _LEGEND_COLUMNS)
    low, high = axes.get_ylim()
    if axes.get_yscale() == "log":
        axes.set_ylim(low, high * (high / low) ** (0.06 + 0.08 * rows))
    else:
        axes.set_ylim(low, high + (0.05 + 0.08 * rows) * (high - low))
    axes.legend(
        fontsize=8, ncols=_LEGEND_COLUMNS, loc="upper right", borderaxespad=0.2, frameon=False
    )


def _dress(axes: Axes, axis: Axis, *, horizontal: bool) -> None:
    side = axes.xaxis if horizontal else axes.yaxis
    side.set_label_text(axis.text)
    if axis.logarithmic:
        (axes.set_xscale if horizontal else axes.set_yscale)("log")
        low, high = axes.get_xlim() if horizontal else axes.get_ylim()
        plain = FuncFormatter(lambda value, _: f"{value:g}")
        side.set_major_formatter(plain)
        side.set_minor_formatter(plain if high < _DECADE * low else NullFormatter())
        side.set_tick_params(which="both", labelsize=8)
    if axis.ticks is not None:
        names = [name for _, name in axis.ticks]
        side.set_ticks([place for place, _ in axis.ticks], names)
        if horizontal and len(names) > 3 and max(map(len, names)) > 10:
            side.set_tick_params(labelrotation=20, labelsize=8)
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
        shape: dict[str, Any] = {"color": layer.colour, "label": name, "zorder": order}
        if layer.lying:
            axes.barh(layer.place, layer.length, layer.width, left=layer.base, **shape)
        else:
            axes.bar(layer.place, layer.length, layer.width, bottom=layer.base, **shape)
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
    for x, y, text in zip(layer.x, layer.y, layer.labels or (), strict=False):
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
