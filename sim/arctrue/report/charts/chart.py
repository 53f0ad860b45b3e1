"""A figure as data: panels, axes with units, and the layers drawn on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC

Float = NDArray[np.floating[Any]]
Angle = Literal["arcsec", "urad"]
"""Unit in which a reader wants small angles."""

Dash = Literal["solid", "dash", "dot"]
Marker = Literal["circle", "square", "diamond", "hollow"]

ARCSEC: Angle = "arcsec"
URAD: Angle = "urad"
URAD_PER_ARCSEC = RAD_PER_ARCSEC * 1e6
SYMBOLS = {ARCSEC: "″", URAD: "µrad", "deg": "°", "deg/s": "°/s", "1": ""}
"""Of units that are not written as they are spelled."""

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#b5578c", "#b07d00", "#3c8dbc")
"""For up to six series. After Okabe and Ito: they differ for every kind of colour vision."""
CHANNEL_COLOUR = {"capture": COLOURS[0], "reference": COLOURS[1]}
QUIET = "#8a94a0"
"""For what is there and does not matter."""


@dataclass(frozen=True)
class Axis:
    """What is on one axis; ``unit`` "1" has none, ``arcsec`` may be shown as µrad."""

    label: str
    unit: str = "1"
    logarithmic: bool = False
    reach: tuple[float, float] | None = None
    ticks: Sequence[tuple[float, str]] | None = None
    """Places with their names; None: numbers."""
    also: tuple[str, float] | None = None
    """A second unit, and its factor relative to ``unit``: on paper, at the other side."""

    @property
    def text(self) -> str:
        """The label with its unit."""
        symbol = SYMBOLS.get(self.unit, self.unit)
        return f"{self.label}, {symbol}" if symbol else self.label


@dataclass(frozen=True)
class Curve:
    """Points, a line, or both; all arrays have the same shape (points,)."""

    x: Float
    y: Float
    name: str = ""
    colour: str = COLOURS[0]
    kind: Literal["line", "points", "both"] = "line"
    dash: Dash = "solid"
    marker: Marker = "circle"
    y_error: Float | None = None
    width: float = 1.6
    size: float = 5.0
    labels: Sequence[str] = ()
    """Text next to each point."""
    values_shown: bool = False
    """True: the text is the value of y, in the unit that is shown."""

    @property
    def texts(self) -> list[str]:
        """Give the text next to each point; empty: none."""
        if self.values_shown:
            return [f"{value:.3f}" if np.isfinite(value) else "" for value in self.y.tolist()]
        return list(self.labels)


@dataclass(frozen=True)
class Band:
    """From ``low`` to ``high``, shape (points,)."""

    x: Float
    low: Float
    high: Float
    name: str = ""
    colour: str = COLOURS[0]
    opacity: float = 0.3


@dataclass(frozen=True)
class Bars:
    """Upright bars, or lying ones from the left."""

    place: Float
    length: Float
    name: str = ""
    colour: str = COLOURS[0]
    lying: bool = False
    base: float = 0.0
    """Where a bar begins: a logarithmic axis has no 0."""
    width: float = 0.7
    opacity: float = 1.0
    labels: Sequence[str] = ()
    """Text at the end of each bar."""


@dataclass(frozen=True)
class HeatMap:
    """``values`` (len(y), len(x)) by colour, symmetric about 0; NaN stays empty."""

    x: Float
    y: Float
    values: Float
    label: str
    unit: str = ARCSEC


@dataclass(frozen=True)
class Level:
    """A horizontal line across the panel: a floor, a limit."""

    value: float
    name: str = ""
    colour: str = QUIET
    dash: Dash = "dash"


Layer = Curve | Band | Bars | HeatMap | Level


@dataclass(frozen=True)
class Panel:
    """One pair of axes with its layers, drawn in their order."""

    x: Axis
    y: Axis
    layers: Sequence[Layer]
    title: str = ""
    equal_scales: bool = False
    """A unit is as long on both axes, so that a circle is a circle."""


@dataclass(frozen=True)
class Chart:
    """A whole figure. ``words`` says what it shows to a person who cannot see it."""

    name: str
    words: str
    panels: Sequence[Panel]
    columns: int = 1
    """Panels in a row, where there is room."""
    panel_height: float = 2.7
    """Inches on paper."""
    notes: Sequence[str] = field(default_factory=tuple)


def in_unit(chart: Chart, unit: Angle) -> Chart:
    """The chart with every axis in arcseconds shown in ``unit``."""
    if unit == ARCSEC:
        return chart
    return replace(chart, panels=[_panel_in_urad(panel) for panel in chart.panels])


def _panel_in_urad(panel: Panel) -> Panel:
    x_factor, y_factor = _factor(panel.x), _factor(panel.y)
    layers = [_scaled(layer, x_factor, y_factor) for layer in panel.layers]
    return replace(panel, x=_axis(panel.x), y=_axis(panel.y), layers=layers)


def _factor(axis: Axis) -> float:
    return URAD_PER_ARCSEC if axis.unit == ARCSEC else 1.0


def _axis(axis: Axis) -> Axis:
    if axis.unit != ARCSEC:
        return axis
    reach = axis.reach
    if reach is not None:
        reach = (reach[0] * URAD_PER_ARCSEC, reach[1] * URAD_PER_ARCSEC)
    return replace(axis, unit=URAD, reach=reach)


def _scaled(layer: Layer, x: float, y: float) -> Layer:
    if isinstance(layer, Curve):
        error = None if layer.y_error is None else layer.y_error * y
        return replace(layer, x=layer.x * x, y=layer.y * y, y_error=error)
    if isinstance(layer, Band):
        return replace(layer, x=layer.x * x, low=layer.low * y, high=layer.high * y)
    if isinstance(layer, Bars):
        factor = x if layer.lying else y
        return replace(layer, length=layer.length * factor, base=layer.base * factor)
    if isinstance(layer, HeatMap):
        if layer.unit != ARCSEC:
            return layer
        return replace(layer, values=layer.values * URAD_PER_ARCSEC, unit=URAD)
    return replace(layer, value=layer.value * y)


def angle_axis(label: str = "angle of the table") -> Axis:
    """Once round, in degrees; :class:`AngleWindow` has that of what was measured."""
    ticks = [(float(place), f"{place}") for place in range(0, 361, 45)]
    return Axis(label, "deg", reach=(0.0, 360.0), ticks=ticks)


def signed(value: float, digits: int) -> str:
    """A number with its sign; a true minus."""
    return f"{value:+.{digits}f}".replace("-", "−")
