"""Converts matplotlib figures to SVG text for an HTML page."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

INK = "#1c2530"
MUTED = "#6b7785"
GRID = "#e3e7ec"
BEFORE = "#c2492f"
AFTER = "#1f6f9f"
LIMIT = "#8a94a0"

_STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "arctrue",
    "font.family": "sans-serif",
    "font.sans-serif": ["Inter", "Segoe UI", "Helvetica Neue", "Arial", "DejaVu Sans"],
    "font.size": 10,
    "axes.edgecolor": "#b5bdc7",
    "axes.labelcolor": INK,
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.8,
    "text.color": INK,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "legend.frameon": False,
}


@contextmanager
def house_style() -> Iterator[None]:
    """Apply the house style to all figures that are made inside the ``with`` block."""
    with mpl.rc_context(_STYLE):
        yield


def to_svg(figure: Figure) -> str:
    """Return the figure as an ``<svg>`` element that scales with the page."""
    text = io.StringIO()
    with house_style():
        figure.savefig(text, format="svg", metadata={"Date": None}, dpi=200)
    svg = text.getvalue()
    svg = svg[svg.index("<svg") :]
    head, rest = svg.split(">", 1)
    # A size in points would fix the width on the page; with only the viewBox the figure scales with
    # the page.
    kept = [part for part in head.split(" ") if not part.startswith(("width=", "height="))]
    return " ".join(kept) + ">" + rest
