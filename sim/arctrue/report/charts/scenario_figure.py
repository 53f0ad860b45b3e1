"""Draws the course of a scenario: error turn by turn, temperature and events."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from arctrue.instrument.turn_score import BINS, TurnScore
from arctrue.report.log_scale import set_log_y
from arctrue.report.picture_file import save_picture
from arctrue.report.svg import AFTER, BEFORE, LIMIT, MUTED, house_style
from arctrue.studies.scenario.result import ScenarioResult, ScenarioTurn


def plot_scenario(result: ScenarioResult, file: Path) -> None:
    """Write the picture in the format of the file name's ending (.svg, .png, .pdf)."""
    with house_style():
        figure = Figure(figsize=(9.6, 8.0), layout="constrained")
        by_turn, warmth, shape = figure.subplots(3, 1, height_ratios=[3, 1.3, 2.4])
        warmth.sharex(by_turn)
        _by_turn(by_turn, result)
        _warmth(warmth, result)
        _shape(shape, result)
        figure.suptitle(result.scenario.title, x=0.01, ha="left", fontweight="bold")
        save_picture(figure, file)


def _rms(found: TurnScore | None) -> float:
    return float("nan") if found is None else found.rms_arcsec


def _by_turn(axes: Axes, result: ScenarioResult) -> None:
    numbers = [turn.number for turn in result.turns]
    for name, colour, values in (
        ("head 1, not corrected", BEFORE, [_rms(turn.uncorrected) for turn in result.turns]),
        ("output, corrected", AFTER, [_rms(turn.corrected) for turn in result.turns]),
    ):
        axes.plot(numbers, values, "o-", color=colour, label=name)
    limit = result.scenario.limits.corrected_rms_arcsec
    if limit is not None:
        axes.axhline(limit, color=LIMIT, linestyle=(0, (4, 3)), linewidth=1, label="limit")
    set_log_y(axes)
    axes.set_ylabel("RMS error, arcsec")
    axes.set_title("Error against the true angle")
    bottom, top = axes.get_ylim()
    # Leave space for the names of the events above the curves.
    axes.set_ylim(bottom, top * (top / bottom) ** 1.1)
    for turn in result.turns:
        if said := _said(turn):
            axes.axvline(turn.number, color=MUTED, linestyle=":", linewidth=1)
            axes.annotate(
                said,
                (turn.number, 0.99),
                xycoords=("data", "axes fraction"),
                xytext=(-6, 0),
                textcoords="offset points",
                rotation=90,
                ha="right",
                va="top",
                fontsize=7,
                color=MUTED,
                bbox={"facecolor": "white", "linewidth": 0, "pad": 1},
            )
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.2)


def _said(turn: ScenarioTurn) -> str:
    refused = [
        f"refused: {t['reason'].replace('_', ' ')}"
        for t in turn.telemetry
        if t["result"] == "refused"
    ]
    return "; ".join((*turn.events, *refused))


def _warmth(axes: Axes, result: ScenarioResult) -> None:
    axes.plot(
        [t.number for t in result.turns], [t.temperature_c for t in result.turns], color=LIMIT
    )
    axes.set_ylabel("table, °C")
    axes.set_xlabel("turn")
    axes.set_xticks([turn.number for turn in result.turns])


def _shape(axes: Axes, result: ScenarioResult) -> None:
    degrees = (np.arange(BINS) + 0.5) * (360 / BINS)
    corrected = [t for t in result.turns if t.corrected is not None]
    wanted = [t for t in corrected if t.number >= result.scenario.limits.from_turn]
    for turn, colour in zip(_ends(wanted or corrected), (AFTER, LIMIT), strict=False):
        if turn.corrected is not None:
            label = f"turn {turn.number}"
            axes.plot(degrees, turn.corrected.error_arcsec, color=colour, label=label, linewidth=1)
    axes.set_title("Corrected output")
    axes.set_ylabel("error, arcsec")
    axes.set_xlabel("true angle of the table, °")
    axes.set_xlim(0, 360)
    axes.set_xticks(range(0, 361, 45))
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.2)


def _ends(turns: list[ScenarioTurn]) -> list[ScenarioTurn]:
    return turns if len(turns) < 2 else [turns[0], turns[-1]]
