"""What the workbench's pictures share: paper, colours, and how they are written."""

from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from arctrue.report.picture_file import save_picture

COLOURS = ("#1f5f99", "#c2571a", "#3a7d44", "#7b4ea3", "#a03050", "#5a6470")
CHANNEL_COLOUR = {"capture": COLOURS[0], "reference": COLOURS[1]}
QUIET = "#8a94a0"
"""For what is there and does not matter."""
_DOTS_PER_INCH = 130


def png_figure(width: float, height: float) -> Figure:
    """An empty figure, inches."""
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def plain_axes(axes: Axes) -> None:
    """Two spines and a light grid behind."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(visible=True, color="#e4e7ea", linewidth=0.6)
    axes.set_axisbelow(True)


def save_png(figure: Figure, folder: Path, name: str) -> Path:
    """Write ``folder/name``; the folder is made."""
    return save_picture(figure, folder / name, dots_per_inch=_DOTS_PER_INCH)
