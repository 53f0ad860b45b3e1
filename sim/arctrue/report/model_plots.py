"""Pictures of a model: the candidates to join it, and the error that falls as it grows."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from arctrue.report.log_scale import set_log_y, set_symmetric_log_x
from arctrue.report.png import CHANNEL_COLOUR, COLOURS, QUIET, plain_axes, png_figure, save_png
from arctrue.workbench.diagnose.diagnosis import Diagnosis
from arctrue.workbench.model.model import HistoryStep

SHOWN_CANDIDATES = 10
LINEAR_TO = 10.0
"""ΔBIC is drawn linearly up to here: odds of 150 to 1."""


def plot_candidates(result: Diagnosis, folder: Path) -> Path:
    """ΔBIC of the leading candidates as bars, linear up to ±10, logarithmic beyond."""
    shown = result.candidates[:SHOWN_CANDIDATES][::-1]
    figure = png_figure(8.6, 1.2 + 0.36 * max(len(shown), 1))
    axes = figure.subplots()
    colours = [_colour(item.name, result) for item in shown]
    bars = axes.barh([item.name for item in shown], [item.delta_bic for item in shown])
    for bar, colour in zip(bars, colours, strict=True):
        bar.set_color(colour)
    axes.bar_label(
        bars, [f"{item.delta_bic:,.0f}".replace("-", "−") for item in shown], padding=4, fontsize=8
    )
    set_symmetric_log_x(axes, LINEAR_TO)
    axes.axvline(0.0, color=QUIET, linewidth=0.8)
    plain_axes(axes)
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)
    axes.margins(x=0.12)
    axes.set_xlabel(
        f"ΔBIC: evidence for the effect, freedom and search charged for (linear to ±{LINEAR_TO:g})"
    )
    axes.set_title(_verdict(result), loc="left")
    return save_png(figure, folder, "candidates.png")


def _colour(name: str, result: Diagnosis) -> str:
    if result.named is not None and name == result.named.name:
        return COLOURS[2]
    return COLOURS[1] if name in result.effect_class else COLOURS[0]


def _verdict(result: Diagnosis) -> str:
    if result.named is not None:
        return f"Verdict: named, {result.named.name}"
    if result.verdict == "ambiguous":
        return f"Verdict: ambiguous between {', '.join(result.effect_class)}"
    return f"Verdict: {result.verdict}"


def plot_history(history: Sequence[HistoryStep], folder: Path) -> Path:
    """RMS of each channel at every step, held out too, above the noise of the repeats."""
    channels = [
        channel for channel in CHANNEL_COLOUR if any(channel in step.rms_arcsec for step in history)
    ]
    steps = max(len(history), 2)
    figure = png_figure(2.6 + (2.4 + 0.5 * steps) * max(len(channels), 1), 3.9)
    panels = np.atleast_1d(figure.subplots(1, max(len(channels), 1), sharey=True))
    for axes, channel in zip(panels, channels, strict=True):
        _draw_ladder(axes, history, channel)
    for which in ("major", "minor"):
        panels[0].yaxis.set_tick_params(which=which, labelsize=8)
    set_log_y(panels[0])
    low, high = panels[0].get_ylim()
    if high < 12 * low:
        set_log_y(panels[0], label_minor_ticks=True)
    panels[0].set_ylabel("RMS of what the model leaves, ″")
    return save_png(figure, folder, "history.png")


def _draw_ladder(axes: Axes, history: Sequence[HistoryStep], channel: str) -> None:
    places = np.arange(len(history))
    fitted = [step.rms_arcsec.get(channel, np.nan) for step in history]
    held_out = [step.heldout_rms_arcsec.get(channel, np.nan) for step in history]
    noise = [step.noise_arcsec.get(channel, np.nan) for step in history]
    colour = CHANNEL_COLOUR[channel]
    axes.plot(places, noise, ":", color=QUIET, linewidth=1.6, label="noise of repeats")
    axes.plot(places, fitted, "o-", color=colour, markersize=5, label="fitted rows")
    axes.plot(
        places,
        held_out,
        "s",
        markersize=9,
        markerfacecolor="none",
        color=colour,
        label="held-out rows",
    )
    for place, value in zip(places, fitted, strict=True):
        axes.annotate(
            f"{value:.3f}″",
            (place, value),
            xytext=(0, 9),
            textcoords="offset points",
            ha="center",
            fontsize=8,
            bbox={"boxstyle": "square,pad=0.1", "color": "white", "alpha": 0.8},
        )
    axes.set_xticks(
        places,
        [f"{number} {step.action}\n{step.effect}" for number, step in enumerate(history, 1)],
        fontsize=8,
        rotation=0 if len(history) <= 3 else 25,
        ha="center" if len(history) <= 3 else "right",
    )
    axes.margins(x=0.3 / max(len(history) - 1, 1), y=0.18)
    plain_axes(axes)
    axes.grid(axis="x", visible=False)
    axes.set_title(channel.capitalize(), loc="left")
    axes.legend(fontsize=8, frameon=False, loc="upper right")
