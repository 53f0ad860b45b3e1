"""Makes logarithmic axes whose labels are plain numbers.

matplotlib's own labels are powers of ten in mathematical notation. They would show their source
text, because this package switches off the parsing of mathematics in figures.
"""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import FuncFormatter, NullFormatter


def set_log_y(axes: Axes, *, label_minor_ticks: bool = False) -> None:
    """Make the vertical axis logarithmic."""
    axes.set_yscale("log")
    _label_with_numbers(axes.yaxis, label_minor_ticks)


def set_log_x(axes: Axes, *, label_minor_ticks: bool = False) -> None:
    """Make the horizontal axis logarithmic."""
    axes.set_xscale("log")
    _label_with_numbers(axes.xaxis, label_minor_ticks)


def _label_with_numbers(axis: Axis, label_minor_ticks: bool) -> None:
    axis.set_major_formatter(FuncFormatter(_number))
    axis.set_minor_formatter(FuncFormatter(_number) if label_minor_ticks else NullFormatter())


def _number(value: float, _: int | None) -> str:
    return f"{value:,.10g}".replace("-", "−")
