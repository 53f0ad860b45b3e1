"""Pictures of a model: the candidates to join it, and the error that falls as it grows."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from arctrue.report.charts.ladder import ladder
from arctrue.report.charts.matplotlib_chart import save_chart
from arctrue.report.log_scale import set_symmetric_log_x
from arctrue.report.png import COLOURS, QUIET, plain_axes, png_figure, save_png
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
    return save_chart(ladder(history), folder / "history.png")
