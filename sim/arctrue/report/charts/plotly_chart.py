"""A chart as the data that plotly.js draws; colours of paper and ink are set by the page."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

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

_SYMBOL = {"circle": "circle", "square": "square", "diamond": "diamond", "hollow": "square-open"}
_LEFT_PX, _RIGHT_PX, _FOOT_PX, _TITLE_PX, _LINE_PX, _INCH_PX = 66, 18, 52, 26, 19, 84
_COLOURS_PX = 74
"""Right of a panel, where a scale of colours stands."""
_ENTRY_PX, _LETTER_PX = 46, 6.0
"""Of an entry of a legend, and of each letter of its name."""
_BESIDE_PX = 300
"""A panel beside another is at least so wide."""
_DIGITS = 6
"""Significant digits that go to the browser: more than a screen shows."""


def chart_data(chart: Chart, width: int = 900) -> dict[str, Any]:
    """``{"data": [...], "layout": {...}}`` as JSON can hold it; what is not finite is null.

    ``width``: pixels that the figure will have. Panels stand side by side where there is room;
    above each its title, and its legend in as many lines as it needs.
    """
    beside = chart.beside and width >= _BESIDE_PX * len(chart.panels)
    columns = max(len(chart.panels), 1) if beside else 1
    mapped = any(isinstance(layer, HeatMap) for panel in chart.panels for layer in panel.layers)
    right = _COLOURS_PX if mapped else _RIGHT_PX
    wide = width / columns - _LEFT_PX - right
    heads = [_TITLE_PX + _LINE_PX * _legend_lines(panel, wide) for panel in chart.panels]
    body = round(_INCH_PX * chart.panel_height)
    if beside:
        tops = [max(heads, default=0)] * len(heads)
        height = max(heads, default=0) + body + _FOOT_PX
    else:
        tops = [sum(heads[: n + 1]) + n * (body + _FOOT_PX) for n in range(len(heads))]
        height = sum(heads) + max(len(heads), 1) * (body + _FOOT_PX)
    inner = height - _FOOT_PX
    layout: dict[str, Any] = {
        "height": height,
        "margin": {"l": _LEFT_PX, "r": right, "t": 0, "b": _FOOT_PX, "autoexpand": False},
        "barmode": "overlay",
        "showlegend": True,
        "annotations": [],
        "shapes": [],
        "meta": {"words": chart.words},
    }
    traces: list[dict[str, Any]] = []
    for index, panel in enumerate(chart.panels):
        suffix = "" if index == 0 else str(index + 1)
        across = _columns(index, columns, width) if beside else (0.0, 1.0)
        upright = (1.0 - (tops[index] + body) / inner, 1.0 - tops[index] / inner)
        layout[f"xaxis{suffix}"] = {**_axis(panel.x), "domain": across, "anchor": f"y{suffix}"}
        layout[f"yaxis{suffix}"] = {**_axis(panel.y), "domain": upright, "anchor": f"x{suffix}"}
        layout[f"legend{suffix}"] = {
            "orientation": "h",
            "x": across[0],
            "xanchor": "left",
            "y": upright[1],
            "yanchor": "bottom",
            "font": {"size": 11},
            "bgcolor": "rgba(0,0,0,0)",
        }
        for layer in panel.layers:
            traces += [
                {
                    **trace,
                    "xaxis": f"x{suffix}",
                    "yaxis": f"y{suffix}",
                    **({} if trace["type"] == "heatmap" else {"legend": f"legend{suffix}"}),
                }
                for trace in _traces(layer, layout, suffix, upright)
            ]
        if panel.title:
            layout["annotations"].append(
                {
                    "text": f"<b>{_plain(panel.title)}</b>",
                    "xref": "paper",
                    "yref": "paper",
                    "x": across[0],
                    "y": upright[1] + (heads[index] - 4) / inner,
                    "xanchor": "left",
                    "yanchor": "top",
                    "showarrow": False,
                }
            )
    return {"data": traces, "layout": layout}


def _columns(index: int, columns: int, width: int) -> tuple[float, float]:
    inner = max(width - _LEFT_PX - _RIGHT_PX, 1)
    gap = (_LEFT_PX + _RIGHT_PX) / inner
    share = (1.0 - gap * (columns - 1)) / columns
    return index * (share + gap), min(index * (share + gap) + share, 1.0)


def _legend_lines(panel: Panel, width: float) -> int:
    names = [getattr(layer, "name", "") for layer in panel.layers]
    widths = [_ENTRY_PX + _LETTER_PX * len(name) for name in names if name]
    if not widths:
        return 0
    # plotly.js gives every entry of a legend the width of the widest.
    per_line = max(int(width // max(widths)), 1)
    return -(-len(widths) // per_line)


def _axis(axis: Axis) -> dict[str, Any]:
    found: dict[str, Any] = {"title": {"text": _plain(axis.text), "standoff": 6}}
    if axis.logarithmic:
        found |= {"type": "log", "exponentformat": "none"}
        if axis.reach is None:
            found["dtick"] = 1  # decades
    if axis.ticks is not None:
        found |= {
            "tickmode": "array",
            "tickvals": [place for place, _ in axis.ticks],
            "ticktext": [_plain(name) for _, name in axis.ticks],
        }
    if axis.reach is not None:
        low, high = axis.reach
        found["range"] = (
            [float(np.log10(low)), float(np.log10(high))] if axis.logarithmic else [low, high]
        )
    return found


def _traces(
    layer: Layer, layout: dict[str, Any], suffix: str, upright: tuple[float, float]
) -> list[dict[str, Any]]:
    if isinstance(layer, Curve):
        return [_curve(layer)]
    if isinstance(layer, Band):
        shared = {"mode": "lines", "type": "scatter", "hoverinfo": "skip"}
        edge = {"width": 0.8 if layer.opacity == 1.0 else 0.0, "color": layer.colour}
        return [
            {"x": _list(layer.x), "y": _list(layer.low), "line": edge, "showlegend": False}
            | shared,
            {
                "x": _list(layer.x),
                "y": _list(layer.high),
                "line": edge,
                "fill": "tonexty",
                "fillcolor": _with_opacity(layer.colour, layer.opacity),
                "name": _plain(layer.name),
                "showlegend": bool(layer.name),
            }
            | shared,
        ]
    if isinstance(layer, Bars):
        place, length = _list(layer.place), _list(layer.length)
        return [
            {
                "type": "bar",
                "x": length if layer.lying else place,
                "y": place if layer.lying else length,
                "orientation": "h" if layer.lying else "v",
                "width": layer.width,
                "base": layer.base,
                "marker": {"color": layer.colour},
                "name": _plain(layer.name),
                "showlegend": bool(layer.name),
            }
        ]
    if isinstance(layer, HeatMap):
        return [_heat_map(layer, upright)]
    return [_level(layer, layout, suffix)]


def _curve(layer: Curve) -> dict[str, Any]:
    mode = {"line": "lines", "points": "markers", "both": "lines+markers"}[layer.kind]
    trace: dict[str, Any] = {
        "type": "scatter",
        "mode": mode + ("+text" if layer.labels else ""),
        "x": _list(layer.x),
        "y": _list(layer.y),
        "name": _plain(layer.name),
        "showlegend": bool(layer.name),
        "line": {"color": layer.colour, "width": layer.width, "dash": layer.dash},
        "marker": {"color": layer.colour, "size": layer.size + 1, "symbol": _SYMBOL[layer.marker]},
    }
    if layer.labels:
        trace |= {"text": [_plain(text) for text in layer.labels], "textposition": "top center"}
    if layer.y_error is not None:
        trace["error_y"] = {"array": _list(layer.y_error), "thickness": 1, "width": 2}
    return trace


def _heat_map(layer: HeatMap, upright: tuple[float, float]) -> dict[str, Any]:
    reach = float(np.nanmax(np.abs(layer.values), initial=0.0)) or 1.0
    symbol = SYMBOLS.get(layer.unit, layer.unit)
    return {
        "type": "heatmap",
        "x": _list(layer.x),
        "y": _list(layer.y),
        "z": [_list(row) for row in layer.values],
        "zmin": -reach,
        "zmax": reach,
        "colorscale": [[0.0, "#b35806"], [0.5, "#f7f7f7"], [1.0, "#542788"]],
        "colorbar": {
            "title": {"text": _plain(symbol), "side": "top"},
            "x": 1.0,
            "xpad": 8,
            "tickfont": {"size": 10},
            "len": upright[1] - upright[0],
            "y": sum(upright) / 2.0,
            "thickness": 12,
        },
    }


def _level(layer: Level, layout: dict[str, Any], suffix: str) -> dict[str, Any]:
    """A shape across the panel, and an entry of the legend."""
    line = {"color": layer.colour, "width": 1.4, "dash": layer.dash}
    layout["shapes"].append(
        {
            "type": "line",
            "xref": f"x{suffix} domain",
            "yref": f"y{suffix}",
            "x0": 0,
            "x1": 1,
            "y0": layer.value,
            "y1": layer.value,
            "line": line,
        }
    )
    return {
        "type": "scatter",
        "mode": "lines",
        "x": [None],
        "y": [layer.value],
        "line": line,
        "name": _plain(layer.name),
        "showlegend": bool(layer.name),
    }


def _list(values: NDArray[np.float64]) -> list[float | None]:
    return [
        float(f"{value:.{_DIGITS}g}") if np.isfinite(value) else None
        for value in np.asarray(values, dtype=np.float64).tolist()
    ]


def _with_opacity(colour: str, opacity: float) -> str:
    red, green, blue = (int(colour[place : place + 2], 16) for place in (1, 3, 5))
    return f"rgba({red},{green},{blue},{opacity:g})"


def _plain(text: str) -> str:
    """plotly.js takes a few tags in its texts: a name of a file has none."""
    return text.replace("&", "&amp;").replace("<", "&lt;").replace("\n", "<br>")
