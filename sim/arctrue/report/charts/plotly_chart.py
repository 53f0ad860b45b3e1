"""Converts a chart to data that plotly.js draws; the page sets the colours of paper and ink."""

from __future__ import annotations

import math
import textwrap
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
from arctrue.report.charts.tick_names import tick_lines, tick_names

_SYMBOL = {"circle": "circle", "square": "square", "diamond": "diamond", "hollow": "square-open"}
_LEFT_PX, _RIGHT_PX, _FOOT_PX, _TITLE_PX, _LINE_PX, _INCH_PX = 66, 18, 52, 26, 19, 84
_COLOURS_PX = 74
"""Width in pixels that a colour scale needs right of its panel."""
_ENTRY_PX, _LETTER_PX = 46, 6.0
"""Width of a legend entry without its name, and width of each letter of the name, pixels."""
_TITLE_LETTER_PX = 8.0
"""Width of a letter of a title, which is bold, pixels; measured in Chromium with DejaVu Sans."""
_TICK_LINE_PX = 16
"""Height of each line of a tick's name after the first, pixels."""
_BESIDE_PX = 300
"""Smallest width of a panel in a row of several panels, pixels."""
_ONE_TWO_FIVE = (1.0, 2.0, 5.0)
_EVERY_DIGIT = tuple(float(digit) for digit in range(1, 10))
_EVERY_TWENTIETH = tuple(n / 20.0 for n in range(20, 200))
_LEAST_TICKS, _MOST_TICKS = 3, 10
_DIGITS = 6
"""Number of significant digits of the numbers for the browser; a screen shows fewer digits."""


def chart_data(chart: Chart, width: int = 900) -> dict[str, Any]:
    """Return ``{"data": [...], "layout": {...}}`` for JSON; numbers that are not finite become
    null.

    ``width``: width of the figure in pixels. The figure places panels in a row if there is room.
    Each panel has a title above it, and a legend with as many lines as it needs.
    """
    panels = chart.panels
    columns = max(min(chart.columns, len(panels), width // _BESIDE_PX), 1)
    mapped = any(isinstance(layer, HeatMap) for panel in panels for layer in panel.layers)
    right = _COLOURS_PX if mapped else _RIGHT_PX
    wide = width / columns - _LEFT_PX - right
    body = round(_INCH_PX * chart.panel_height)
    tops, heads, feet, height = [], [], [], 0
    for start in range(0, len(panels), columns):
        row = panels[start : start + columns]
        named = [tick_names(panel.x, wide / _LETTER_PX) for panel in row]
        head = max(
            _TITLE_PX + _LINE_PX * (len(_title_lines(panel, wide)) - 1 + _legend_lines(panel, wide))
            for panel in row
        )
        heads += [head] * len(row)
        tops += [height + head] * len(row)
        feet.append(_FOOT_PX + _TICK_LINE_PX * (max(map(tick_lines, named)) - 1))
        height += head + body + feet[-1]
    inner = height - feet[-1]
    layout: dict[str, Any] = {
        "height": height,
        "margin": {"l": _LEFT_PX, "r": right, "t": 0, "b": feet[-1], "autoexpand": False},
        "barmode": "overlay",
        "showlegend": True,
        "annotations": [],
        "shapes": [],
    }
    traces: list[dict[str, Any]] = []
    for index, panel in enumerate(panels):
        suffix = "" if index == 0 else str(index + 1)
        across = _columns(index % columns, columns, width)
        upright = (1.0 - (tops[index] + body) / inner, 1.0 - tops[index] / inner)
        layout[f"xaxis{suffix}"] = {
            **_axis(panel.x, wide),
            "domain": across,
            "anchor": f"y{suffix}",
        }
        layout[f"yaxis{suffix}"] = {
            **_axis(panel.y, body),
            "domain": upright,
            "anchor": f"x{suffix}",
            **({"scaleanchor": f"x{suffix}"} if panel.equal_scales else {}),
        }
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
                    "text": f"<b>{'<br>'.join(map(_plain, _title_lines(panel, wide)))}</b>",
                    "align": "left",
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


def _title_lines(panel: Panel, width: float) -> list[str]:
    """Return the lines of a panel's title; an empty title has one line, which is empty."""
    return textwrap.wrap(panel.title, max(int(width // _TITLE_LETTER_PX), 1)) or [""]


def _legend_lines(panel: Panel, width: float) -> int:
    names = [getattr(layer, "name", "") for layer in panel.layers]
    widths = [_ENTRY_PX + _LETTER_PX * len(name) for name in names if name]
    if not widths:
        return 0
    # plotly.js makes every entry of a legend as wide as the widest entry.
    per_line = max(int(width // max(widths)), 1)
    return -(-len(widths) // per_line)


def _axis(axis: Axis, pixels: float) -> dict[str, Any]:
    found: dict[str, Any] = {"title": {"text": _plain(axis.text), "standoff": 6}}
    if axis.logarithmic:
        found |= {"type": "log", "exponentformat": "none"}
        if axis.reach is None:
            found["dtick"] = 1  # one tick per decade
        else:
            ticks = _logarithmic_ticks(*axis.reach)
            texts = [f"{tick:.4g}" for tick in ticks]
            found |= {"tickmode": "array", "tickvals": ticks, "ticktext": texts}
    if axis.ticks is not None:
        named = tick_names(axis, pixels / _LETTER_PX)
        found |= {
            "tickmode": "array",
            "tickvals": [place for place, _ in named],
            "ticktext": [_plain(name) for _, name in named],
            "tickangle": 0,
        }
    if axis.reach is not None:
        low, high = axis.reach
        found["range"] = (
            [float(np.log10(low)), float(np.log10(high))] if axis.logarithmic else [low, high]
        )
    return found


def _logarithmic_ticks(low: float, high: float) -> list[float]:
    """Return ticks at 1, 2 and 5 in each decade; if these are too few, ticks at every digit or in
    steps of 0.05."""
    for digits in (_ONE_TWO_FIVE, _EVERY_DIGIT, _EVERY_TWENTIETH):
        decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
        ticks = [digit * 10.0**decade for decade in decades for digit in digits]
        found = [tick for tick in ticks if low <= tick <= high]
        if len(found) >= _LEAST_TICKS:
            break
    return found[:: max(math.ceil(len(found) / _MOST_TICKS), 1)]


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
                "marker": {"color": layer.colour, "opacity": layer.opacity},
                "name": _plain(layer.name),
                "showlegend": bool(layer.name),
                **_bar_labels(layer),
            }
        ]
    if isinstance(layer, HeatMap):
        return [_heat_map(layer, upright)]
    return [_level(layer, layout, suffix)]


def _curve(layer: Curve) -> dict[str, Any]:
    mode = {"line": "lines", "points": "markers", "both": "lines+markers"}[layer.kind]
    trace: dict[str, Any] = {
        "type": "scatter",
        "mode": mode + ("+text" if layer.texts else ""),
        "x": _list(layer.x),
        "y": _list(layer.y),
        "name": _plain(layer.name),
        "showlegend": bool(layer.name),
        "line": {"color": layer.colour, "width": layer.width, "dash": layer.dash},
        "marker": {"color": layer.colour, "size": layer.size + 1, "symbol": _SYMBOL[layer.marker]},
    }
    if layer.texts:
        trace |= {"text": [_plain(text) for text in layer.texts], "textposition": "top center"}
    if layer.y_error is not None:
        trace["error_y"] = {"array": _list(layer.y_error), "thickness": 1, "width": 2}
    return trace


def _bar_labels(layer: Bars) -> dict[str, Any]:
    if not layer.labels:
        return {}
    return {"text": [_plain(text) for text in layer.labels], "textposition": "outside"}


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
    """Add a line across the panel to the layout, and return the line's entry of the legend."""
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


def _list(values: NDArray[np.floating[Any]]) -> list[float | None]:
    return [
        float(f"{value:.{_DIGITS}g}") if np.isfinite(value) else None
        for value in np.asarray(values, dtype=np.float64).tolist()
    ]


def _with_opacity(colour: str, opacity: float) -> str:
    red, green, blue = (int(colour[place : place + 2], 16) for place in (1, 3, 5))
    return f"rgba({red},{green},{blue},{opacity:g})"


def _plain(text: str) -> str:
    """Escape & and <, so that plotly.js shows a text (for example a name from a file) literally and
    does not read it as tags; line ends become <br>."""
    return text.replace("&", "&amp;").replace("<", "&lt;").replace("\n", "<br>")
