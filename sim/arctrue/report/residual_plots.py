"""Pictures of ``arctrue compare``: residuals by run and direction, and against every condition."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import SubFigure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from arctrue.base.percent import percent
from arctrue.report.charts.branches import branches
from arctrue.report.charts.matplotlib_chart import save_chart
from arctrue.report.charts.spectrum import all_spectra
from arctrue.report.charts.whitened import whitened
from arctrue.report.png import CHANNEL_COLOUR, QUIET, plain_axes, png_figure, save_png
from arctrue.workbench.compare.comparison import ModelComparison
from arctrue.workbench.compare.findings import LEAST_SHARE, Finding
from arctrue.workbench.compare.maps import ResidualMap
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.solution import Solution

Float = NDArray[np.float64]

PART_OF_A_TURN_DEG = 180.0
"""A set that covers less is drawn over what it covers."""
MAP_COLUMNS = 3
WAVES = ("angle", "electrical phase of head 1", "electrical phase of head 2")
"""Conditions that go round. A capture fills them: its means are joined by a line."""
SYMBOLS = {"deg": "°", "deg/s": "°/s"}


def plot_comparison(solution: Solution, comparison: ModelComparison, folder: Path) -> list[Path]:
    """Branches by run and direction against the angle, all maps, lines, whitened; PNG files."""
    noise_arcsec = {name: item.noise_arcsec for name, item in comparison.channels.items()}
    return [
        save_chart(branches(Residuals(solution), noise_arcsec), folder / "residual_branches.png"),
        _plot_maps(comparison.maps, comparison.findings, folder),
        save_chart(all_spectra(Residuals(solution)), folder / "residual_lines.png"),
        save_chart(whitened(Residuals(solution)), folder / "residual_whitened.png"),
    ]


def _plot_maps(maps: Sequence[ResidualMap], findings: Sequence[Finding], folder: Path) -> Path:
    channels = [name for name in CHANNEL_COLOUR if any(item.channel == name for item in maps)]
    shown = [[item for item in maps if item.channel == name] for name in channels]
    rows = [max(-(-len(items) // MAP_COLUMNS), 1) for items in shown]
    # The sentences first, in as much room as they need.
    told = 0.25 + 0.12 * len(findings) if findings else 0.0
    figure = png_figure(11.0, 0.5 * len(rows) + 2.3 * max(sum(rows) + told, 1.0))
    if channels:
        heights = [*([told] if findings else []), *rows]
        parts = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
        if findings:
            draw_findings(parts[0].subplots(), findings)
            parts = parts[1:]
        for part, channel, items, height in zip(parts, channels, shown, rows, strict=True):
            _draw_channel(part, channel, items, height)
    return save_png(figure, folder, "residual_maps.png")


def draw_findings(axes: Axes, findings: Sequence[Finding]) -> None:
    """A bar each: the share of the excess that ``compare`` says in words."""
    places = np.arange(len(findings))
    colours = [CHANNEL_COLOUR[item.channel] for item in findings]
    alone = [100.0 * item.share for item in findings]
    beyond = [100.0 * item.share_beyond for item in findings]
    axes.barh(places, alone, color=colours, alpha=0.3, label="by itself")
    axes.barh(places, beyond, height=0.4, color=colours, label="beyond what is above it")
    axes.set_yticks(places, [f"{item.channel}: {item.follows}" for item in findings], fontsize=8)
    axes.invert_yaxis()
    axes.set_xlim(0.0, 100.0)
    axes.set_xlabel("share of the excess, %", fontsize=9)
    axes.set_title("What the residual follows, as compare says it", loc="left", fontsize=10)
    plain_axes(axes)
    axes.legend(fontsize=8, loc="lower right", frameon=False)


def _draw_channel(part: SubFigure, channel: str, items: Sequence[ResidualMap], rows: int) -> None:
    part.suptitle(
        f"{channel.capitalize()}: mean of what the model leaves, against each condition",
        x=0.01,
        ha="left",
        fontweight="bold",
    )
    panels = part.subplots(rows, MAP_COLUMNS, squeeze=False, sharey=True)
    # One scale a channel: what does not matter looks flat.
    reach = max(
        float(np.max(np.abs(item.means_arcsec) + item.standard_errors_arcsec, initial=0.0))
        for item in items
    )
    for axes, item in zip(panels.ravel(), items, strict=False):
        _draw_map(axes, item)
        axes.set_ylim(-1.15 * reach, 1.4 * reach)
    for axes in panels.ravel()[len(items) :]:
        axes.set_visible(False)
    for axes in panels[:, 0]:
        axes.set_ylabel("mean, ″", fontsize=9)


def _draw_map(axes: Axes, item: ResidualMap) -> None:
    matters = item.excess_share >= LEAST_SHARE
    axes.axhline(0.0, color=QUIET, linewidth=0.8, zorder=1)
    axes.errorbar(
        item.centres,
        item.means_arcsec,
        item.standard_errors_arcsec,
        fmt="o-" if item.condition in WAVES and item.channel == "capture" else "o",
        markersize=3,
        linewidth=0.9,
        color=CHANNEL_COLOUR[item.channel] if matters else QUIET,
    )
    plain_axes(axes)
    unit = SYMBOLS.get(item.unit, item.unit)
    axes.set_xlabel(item.condition if unit == "1" else f"{item.condition}, {unit}", fontsize=9)
    if item.condition in WAVES and np.ptp(item.centres) > PART_OF_A_TURN_DEG:
        axes.set_xlim(-8, 368)
        axes.set_xticks(range(0, 361, 90))
    elif unit == "1":
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.margins(x=0.12)
    share = f"takes {percent(item.share, 1)} of the variance, chance {percent(item.null_share, 1)}"
    axes.annotate(
        share if matters else f"less than {percent(LEAST_SHARE)} beyond chance",
        (0.02, 0.97),
        xycoords="axes fraction",
        va="top",
        fontsize=8,
        color="black" if matters else QUIET,
    )
    axes.tick_params(labelsize=8)
