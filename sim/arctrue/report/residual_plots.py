"""Pictures of the workbench: residuals against every condition, candidates, the falling error."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from arctrue.compare.comparison import Comparison
from arctrue.compare.maps import ResidualMap
from arctrue.diagnose.diagnosis import Diagnosis
from arctrue.fit.residuals import Residuals
from arctrue.fit.solution import Solution
from arctrue.model.model import HistoryStep

BRANCH_BINS = 180
COLOURS = ("#1f5f99", "#c2571a", "#3a7d44", "#7b4ea3", "#a03050", "#5a6470")
SHOWN_CANDIDATES = 10


def _figure(width: float, height: float) -> Figure:
    figure = Figure(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _plain(axes: Axes) -> None:
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(visible=True, color="#e4e7ea", linewidth=0.6)
    axes.set_axisbelow(True)


def _save(figure: Figure, folder: Path, name: str) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / name
    figure.savefig(path, dpi=130)
    return path


def plot_comparison(solution: Solution, comparison: Comparison, folder: Path) -> list[Path]:
    """Branches by run and direction against the angle, and all maps; returns the PNG files."""
    return [_plot_branches(solution, folder), _plot_maps(comparison.maps, folder)]


def _plot_branches(solution: Solution, folder: Path) -> Path:
    residuals = Residuals(solution)
    observations = solution.observations
    capture, reference = observations.capture, observations.reference
    rows = int(capture is not None) + int(reference is not None)
    figure = _figure(9.0, 3.4 * max(rows, 1))
    panels = np.atleast_1d(figure.subplots(max(rows, 1), 1))
    place = 0
    if capture is not None and residuals.capture_arcsec is not None:
        axes = panels[place]
        place += 1
        for run in range(capture.runs):
            inside = capture.run == run
            angle = np.mod(capture.angle_rad[inside], 2.0 * np.pi)
            group = np.floor(angle * (BRANCH_BINS / (2.0 * np.pi))).astype(np.int64) % BRANCH_BINS
            counts = np.maximum(np.bincount(group, minlength=BRANCH_BINS), 1)
            mean = np.bincount(group, residuals.capture_arcsec[inside], BRANCH_BINS) / counts
            speed = np.degrees(float(np.median(capture.speed_rad_s[inside])))
            label = f"run {run}: {speed:+.1f} °/s"
            if capture.temperature_c is not None:
                label += f", {float(np.mean(capture.temperature_c[inside])):.1f} °C"
            degrees = (np.arange(BRANCH_BINS) + 0.5) * 360.0 / BRANCH_BINS
            axes.plot(degrees, mean, linewidth=1.1, color=COLOURS[run % len(COLOURS)], label=label)
        _plain(axes)
        axes.set(xlim=(0, 360), xlabel="angle / °", ylabel="R₂ − R₁ less model / ″")
        axes.set_title("Capture: residual of each run, mean of its turns", loc="left")
        axes.legend(fontsize=8, ncols=2, frameon=False)
    if reference is not None and residuals.reference_arcsec is not None:
        axes = panels[place]
        side = np.ones(reference.run.size) if reference.direction is None else reference.direction
        degrees = np.mod(np.degrees(reference.target_rad), 360.0)
        for index, value in enumerate(np.unique(side)):
            inside = side == value
            axes.plot(
                degrees[inside],
                residuals.reference_arcsec[inside],
                ".",
                markersize=4,
                alpha=0.6,
                color=COLOURS[index % len(COLOURS)],
                label=f"direction {value:+.0f}",
            )
        _plain(axes)
        axes.set(xlabel="angle / °", ylabel="error less model / ″")
        axes.set_title("Reference run: residual by direction", loc="left")
        axes.legend(fontsize=8, frameon=False)
    return _save(figure, folder, "residual_branches.png")


def _plot_maps(maps: Sequence[ResidualMap], folder: Path) -> Path:
    columns = 3
    rows = max((len(maps) + columns - 1) // columns, 1)
    figure = _figure(11.0, 2.5 * rows)
    panels = np.atleast_1d(figure.subplots(rows, columns)).ravel()
    for axes, item in zip(panels, maps, strict=False):
        axes.errorbar(
            item.centres,
            item.means_arcsec,
            item.standard_errors_arcsec,
            fmt="o-",
            markersize=2.5,
            linewidth=0.9,
            color=COLOURS[0] if item.channel == "capture" else COLOURS[1],
        )
        _plain(axes)
        axes.set_title(f"{item.channel}: {item.condition}", loc="left", fontsize=9)
        axes.set_xlabel(
            f"{item.unit}   share {item.share:.1%}, chance {item.null_share:.1%}", fontsize=8
        )
        axes.set_ylabel("″", fontsize=8)
        axes.tick_params(labelsize=7)
    for axes in panels[len(maps) :]:
        axes.set_visible(False)
    return _save(figure, folder, "residual_maps.png")


def plot_candidates(result: Diagnosis, folder: Path) -> Path:
    """ΔBIC of the leading candidates as bars on a symmetric log scale."""
    shown = result.candidates[:SHOWN_CANDIDATES][::-1]
    figure = _figure(8.0, 0.6 + 0.38 * max(len(shown), 1))
    axes = figure.subplots()
    colours = [COLOURS[2] if item is result.named else COLOURS[0] for item in shown]
    axes.barh([item.name for item in shown], [item.delta_bic for item in shown], color=colours)
    axes.set_xscale("symlog", linthresh=10.0)
    axes.axvline(0.0, color="#5a6470", linewidth=0.8)
    _plain(axes)
    axes.set_xlabel("ΔBIC: evidence for the effect, its freedom and its search charged for")
    axes.set_title(f"Verdict: {result.verdict}", loc="left")
    return _save(figure, folder, "candidates.png")


def plot_history(history: Sequence[HistoryStep], folder: Path) -> Path:
    """RMS of each channel at every step, held out too, above the noise of the repeats."""
    figure = _figure(7.5, 3.6)
    axes = figure.subplots()
    places = np.arange(len(history))
    for index, channel in enumerate(("capture", "reference")):
        if not any(channel in step.rms_arcsec for step in history):
            continue
        colour = COLOURS[index]
        for values, style, label in (
            ([step.rms_arcsec.get(channel, np.nan) for step in history], "o-", "fitted"),
            ([step.heldout_rms_arcsec.get(channel, np.nan) for step in history], "s--", "held out"),
            ([step.noise_arcsec.get(channel, np.nan) for step in history], ":", "noise of repeats"),
        ):
            axes.plot(
                places, values, style, color=colour, markersize=5, label=f"{channel}, {label}"
            )
    axes.set_yscale("log")
    axes.set_xticks(places, [f"{step.action} {step.effect}" for step in history], fontsize=8)
    _plain(axes)
    axes.set_ylabel("RMS of what is left / ″")
    axes.set_title("The error falls as the model grows", loc="left")
    axes.legend(fontsize=8, frameon=False)
    return _save(figure, folder, "history.png")
