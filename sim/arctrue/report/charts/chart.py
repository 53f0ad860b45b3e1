"""Defines a figure as data: panels, axes with units, and the layers drawn on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC

Float = NDArray[np.floating[Any]]
Angle = Literal["arcsec", "urad"]
"""Unit in which the reader wants small angles."""

Dash = Literal["solid", "dash", "dot"]
Marker = Literal["circle", "square", "diamond", "hollow"]

ARCSEC: Angle = "arcsec"
URAD: Angle = "urad"
URAD_PER_ARCSEC = RAD_PER_ARCSEC * 1e6
SYMBOLS = {ARCSEC: "″", URAD: "µrad", "deg": "°", "deg/s": "°/s", "1": ""}
"""Symbols of those units whose symbol differs from the unit's key."""

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#b5578c", "#b07d00", "#3c8dbc")
"""Colours of up to six series. The first three are colours of Okabe and Ito, which people with any
type of colour vision can distinguish; the other three are similar to further colours of this
palette."""
CHANNEL_COLOUR = {"capture": COLOURS[0], "reference": COLOURS[1]}
QUIET = "#8a94a0"
"""Colour of elements of minor importance."""


@dataclass(frozen=True)
class Axis:
    """One axis; the ``unit`` "1" means no unit; an axis in ``arcsec`` may be shown in µrad."""

    label: str
    unit: str = "1"
    logarithmic: bool = False
    reach: tuple[float, float] | None = None
    ticks: Sequence[tuple[float, str]] | None = None
    """Positions of the ticks with their names; None: the ticks show numbers."""
    also: tuple[str, float] | None = None
    """A second unit and the factor from ``unit`` to it; on paper its axis is on the opposite
    side."""

    @property
    def text(self) -> str:
        """Label of the axis with its unit."""
        symbol = SYMBOLS.get(self.unit, self.unit)
        return f"{self.label}, {symbol}" if symbol else self.label


@dataclass(frozen=True)
class Curve:
    """A layer of points, a line, or both; all arrays have the same shape (points,)."""

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
    """Whether each point is labelled with its y value in the displayed unit."""

    @property
    def texts(self) -> list[str]:
        """Return the text next to each point; an empty list means that no point has a text."""
        if self.values_shown:
            return [f"{value:.3f}" if np.isfinite(value) else "" for value in self.y.tolist()]
        return list(self.labels)


@dataclass(frozen=True)
class Band:
    """A filled area from ``low`` to ``high``, each of shape (points,)."""

    x: Float
    low: Float
    high: Float
    name: str = ""
    colour: str = COLOURS[0]
    opacity: float = 0.3


@dataclass(frozen=True)
class Bars:
    """Vertical bars; horizontal bars if ``lying``."""

    place: Float
    length: Float
    name: str = ""
    colour: str = COLOURS[0]
    lying: bool = False
    base: float = 0.0
    """Value at which each bar begins; it must be above 0 on a logarithmic axis."""
    width: float = 0.7
    opacity: float = 1.0
    labels: Sequence[str] = ()
    """Text at the end of each bar."""


@dataclass(frozen=True)
class HeatMap:
    """A map of ``values``, shape (len(y), len(x)), as colours symmetric about 0; NaN is left
    blank."""

    x: Float
    y: Float
    values: Float
    label: str
    unit: str = ARCSEC


@dataclass(frozen=True)
class Level:
    """A horizontal line across the panel, such as a noise floor or a limit."""

    value: float
    name: str = ""
    colour: str = QUIET
    dash: Dash = "dash"


Layer = Curve | Band | Bars | HeatMap | Level


@dataclass(frozen=True)
class Panel:
    """One pair of axes and the layers on it, in the order of drawing."""

    x: Axis
    y: Axis
    layers: Sequence[Layer]
    title: str = ""
    equal_scales: bool = False
    """Whether a unit has the same length on both axes; a circle then appears as a circle."""


@dataclass(frozen=True)
class Chart:
    """A whole figure; ``words`` describes the figure for a person who cannot see it."""

    name: str
    words: str
    panels: Sequence[Panel]
    columns: int = 1
    """Number of panels in a row, if the page is wide enough."""
    panel_height: float = 2.7
    """Height of a panel on paper, inches."""
    notes: Sequence[str] = field(default_factory=tuple)


def in_unit(chart: Chart, unit: Angle) -> Chart:
    """Return a copy of the chart in which every axis in arcseconds has the unit ``unit``."""
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
    """Return an axis over the whole turn in degrees; :class:`AngleWindow` shows a measured part."""
    ticks = [(float(place), f"{place}") for place in range(0, 361, 45)]
    return Axis(label, "deg", reach=(0.0, 360.0), ticks=ticks)


def signed(value: float, digits: int) -> str:
    """Format a number with its sign, using the minus sign U+2212."""
    return f"{value:+.{digits}f}".replace("-", "−")
