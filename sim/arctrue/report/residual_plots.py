"""Pictures of ``arctrue compare``: residuals by run and direction, and against every condition."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import SubFigure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from arctrue.report.png import CHANNEL_COLOUR, COLOURS, QUIET, plain_axes, png_figure, save_png
from arctrue.report.spectrum_plots import plot_line_spectrum
from arctrue.workbench.compare.comparison import Comparison
from arctrue.workbench.compare.findings import LEAST_SHARE
from arctrue.workbench.compare.maps import ResidualMap
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.observations import CaptureRows, ReferenceRows

Float = NDArray[np.float64]

BRANCH_BINS = 180
SPARSE_STATIONS = 60
"""Up to so many stations, those of the directions are drawn side by side."""
PART_OF_A_TURN_DEG = 180.0
"""A set that covers less is drawn over what it covers."""
MAP_COLUMNS = 3
WAVES = ("angle", "electrical phase of head 1", "electrical phase of head 2")
"""Conditions that go round. A capture fills them: its means are joined by a line."""
SYMBOLS = {"deg": "°", "deg/s": "°/s"}


def plot_comparison(solution: Solution, comparison: Comparison, folder: Path) -> list[Path]:
    """Branches by run and direction against the angle, all maps, and lines; returns PNG files."""
    noise_arcsec = {name: item.noise_arcsec for name, item in comparison.channels.items()}
    return [
        _plot_branches(solution, noise_arcsec, folder),
        _plot_maps(comparison.maps, folder),
        plot_line_spectrum(solution, folder),
    ]


def _plot_branches(solution: Solution, noise_arcsec: Mapping[str, float], folder: Path) -> Path:
    residuals = Residuals(solution)
    capture, reference = solution.observations.capture, solution.observations.reference
    rows = int(capture is not None) + int(reference is not None)
    figure = png_figure(9.6, 3.6 * max(rows, 1))
    panels = iter(np.atleast_1d(figure.subplots(max(rows, 1), 1)))
    if capture is not None and residuals.capture_arcsec is not None:
        _draw_runs(next(panels), capture, residuals.capture_arcsec, noise_arcsec["capture"])
    if reference is not None and residuals.reference_arcsec is not None:
        _draw_stations(
            next(panels), reference, residuals.reference_arcsec, noise_arcsec["reference"]
        )
    return save_png(figure, folder, "residual_branches.png")


def _draw_runs(axes: Axes, rows: CaptureRows, residual_arcsec: Float, noise: float) -> None:
    degrees = (np.arange(BRANCH_BINS) + 0.5) * 360.0 / BRANCH_BINS
    for run in range(rows.runs):
        inside = rows.run == run
        angle = np.mod(rows.angle_rad[inside], 2.0 * np.pi)
        group = np.floor(angle * (BRANCH_BINS / (2.0 * np.pi))).astype(np.int64) % BRANCH_BINS
        counts = np.bincount(group, minlength=BRANCH_BINS)
        sums = np.bincount(group, residual_arcsec[inside], BRANCH_BINS)
        mean = np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)
        speed = np.degrees(float(np.median(rows.speed_rad_s[inside])))
        label = f"run {run}: {_signed(speed, 1)} °/s"
        if rows.temperature_c is not None:
            label += f", {float(np.mean(rows.temperature_c[inside])):.1f} °C"
        axes.plot(degrees, mean, linewidth=1.1, color=COLOURS[run % len(COLOURS)], label=label)
    each = rows.run.size / max(rows.runs, 1) / BRANCH_BINS
    _draw_noise(axes, 2.0 * noise / np.sqrt(max(each, 1.0)))
    axes.set_title(
        f"Capture: what the model leaves in each run, mean each {360 / BRANCH_BINS:g}°", loc="left"
    )
    axes.set_ylabel("R₂ − R₁ less the model, ″")
    _round_the_turn(axes, np.mod(np.degrees(rows.angle_rad), 360.0))
    _legend_above(axes, rows.runs)


def _draw_stations(axes: Axes, rows: ReferenceRows, residual_arcsec: Float, noise: float) -> None:
    side = np.ones(rows.run.size) if rows.direction is None else rows.direction
    degrees = np.mod(np.degrees(rows.target_rad), 360.0)
    directions = np.unique(side)
    stations = np.unique(np.round(degrees, 4)).size
    beside = 1.6 if stations <= SPARSE_STATIONS and directions.size > 1 else 0.0
    for index, value in enumerate(directions):
        inside = side == value
        axes.plot(
            degrees[inside] + beside * (index - (directions.size - 1) / 2),
            residual_arcsec[inside],
            ".",
            markersize=4,
            alpha=0.6,
            markeredgewidth=0,
            color=COLOURS[index % len(COLOURS)],
            label=f"direction {_signed(float(value), 0)}",
        )
    _draw_noise(axes, 2.0 * noise)
    axes.set_title("Reference run: what the model leaves at each station", loc="left")
    axes.set_ylabel("error less the model, ″")
    _round_the_turn(axes, degrees)
    _legend_above(axes, directions.size)


def _draw_noise(axes: Axes, reach_arcsec: float) -> None:
    axes.axhspan(
        -reach_arcsec,
        reach_arcsec,
        color=QUIET,
        alpha=0.2,
        linewidth=0,
        label=f"noise of repeats, ±2σ = {_three_digits(reach_arcsec)}″",
    )


def _round_the_turn(axes: Axes, degrees: Float) -> None:
    plain_axes(axes)
    axes.axhline(0.0, color=QUIET, linewidth=0.8, zorder=1)
    axes.set_xlabel("angle, °")
    if np.ptp(degrees) > PART_OF_A_TURN_DEG:
        axes.set_xlim(-3, 363)
        axes.set_xticks(range(0, 361, 45))


def _legend_above(axes: Axes, entries: int) -> None:
    # Above what was measured: no corner of these pictures is sure to be free.
    low, high = axes.get_ylim()
    rows = (entries + 1 + 3) // 4
    axes.set_ylim(low, high + (0.06 + 0.07 * rows) * (high - low))
    axes.legend(
        fontsize=8, ncols=4, loc="upper right", borderaxespad=0.2, frameon=False, markerscale=3
    )


def _plot_maps(maps: Sequence[ResidualMap], folder: Path) -> Path:
    channels = [name for name in CHANNEL_COLOUR if any(item.channel == name for item in maps)]
    shown = [[item for item in maps if item.channel == name] for name in channels]
    rows = [max(-(-len(items) // MAP_COLUMNS), 1) for items in shown]
    figure = png_figure(11.0, 0.5 * len(rows) + 2.3 * max(sum(rows), 1))
    if channels:
        parts = figure.subfigures(len(rows), 1, height_ratios=rows, squeeze=False)
        for part, channel, items, height in zip(parts[:, 0], channels, shown, rows, strict=True):
            _draw_channel(part, channel, items, height)
    return save_png(figure, folder, "residual_maps.png")


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
    share = f"takes {item.share:.1%} of the variance, chance {item.null_share:.1%}"
    axes.annotate(
        share if matters else f"less than {LEAST_SHARE:.0%} beyond chance",
        (0.02, 0.97),
        xycoords="axes fraction",
        va="top",
        fontsize=8,
        color="black" if matters else QUIET,
    )
    axes.tick_params(labelsize=8)


def _three_digits(value: float) -> str:
    decimals = 3 if value < 1.0 else 2 if value < 10.0 else 1 if value < 100.0 else 0
    return f"{value:,.{decimals}f}"


def _signed(value: float, digits: int) -> str:
    return f"{value:+.{digits}f}".replace("-", "−")
