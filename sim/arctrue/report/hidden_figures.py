"""The pictures of a hidden effect: three curves over a turn, a signal period, and the ladder."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from arctrue.report.svg import AFTER, BEFORE, INK, house_style, to_svg
from arctrue.studies.hidden_effect.experiment import HiddenResult
from arctrue.studies.hidden_effect.score import SignalScore
from arctrue.whole_file import whole_file

PAPER = "#d0932b"
_NAMES = ("raw", "paper's model", "with the effect")


def three_curves(result: HiddenResult) -> str:
    """Raw, the paper's model and with the effect over one turn, the two last enlarged below."""
    return to_svg(_three_curves(result))


def save_three_curves(result: HiddenResult, file: Path) -> None:
    """The same as a file; its kind by the suffix."""
    figure = _three_curves(result)
    with whole_file(file) as unfinished:
        figure.savefig(
            unfinished, dpi=150, metadata={"Date": None} if file.suffix == ".svg" else None
        )


def _three_curves(result: HiddenResult) -> Figure:
    with house_style():
        figure = Figure(figsize=(9.6, 5.8), layout="constrained")
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[2, 3])
        _band(upper, result.raw, BEFORE, _NAMES[0])
        for axes in (upper, lower):
            _band(axes, result.paper, PAPER, _NAMES[1])
            _band(axes, result.corrected, AFTER, _NAMES[2])
            axes.set_ylabel("error, arcsec")
        upper.set_title("Output against the true angle, every edge")
        upper.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=3)
        lower.set_title("The two corrected turns, enlarged")
        lower.set_xlabel("true angle of the table, °")
        lower.set_xlim(0, 360)
        lower.set_xticks(range(0, 361, 45))
        return figure


def _band(axes: Axes, curve: SignalScore, colour: str, name: str) -> None:
    axes.fill_between(
        np.rad2deg(curve.angle_rad),
        curve.bin_lowest_arcsec,
        curve.bin_highest_arcsec,
        color=colour,
        linewidth=0.9,
        label=name,
    )


def signal_period(result: HiddenResult) -> str:
    """Mean error over one period of the signal, the slow errors removed."""
    with house_style():
        figure = Figure(figsize=(9.6, 3.2), layout="constrained")
        axes = figure.subplots()
        for curve, colour, name, style in (
            (result.raw, BEFORE, _NAMES[0], (0, (5, 2))),
            (result.paper, PAPER, _NAMES[1], "-"),
            (result.corrected, AFTER, _NAMES[2], "-"),
        ):
            middle_deg = (np.arange(curve.phase_arcsec.size) + 0.5) * (
                360 / curve.phase_arcsec.size
            )
            axes.plot(middle_deg, curve.phase_arcsec, color=colour, label=name, linestyle=style)
        axes.set_title("Mean error over a period of the grating", color=INK)
        axes.set_xlabel("electrical phase of head 1, °")
        axes.set_ylabel("error, arcsec")
        axes.set_xlim(0, 360)
        axes.set_xticks(range(0, 361, 45))
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=3)
        return to_svg(figure)


def ladder(result: HiddenResult) -> str:
    """RMS that the model leaves on the set at each step, by channel, beside the output's."""
    steps = result.examined.ladder
    labels = ["paper's model", *(step.effect.replace("_", " ") for step in steps[1:])]
    with house_style():
        figure = Figure(figsize=(9.6, 3.0), layout="constrained")
        axes = figure.subplots()
        for channel, colour in (("capture", AFTER), ("reference", PAPER)):
            if any(channel not in step.rms_arcsec for step in steps):
                continue
            values = [step.rms_arcsec[channel] for step in steps]
            axes.plot(range(len(steps)), values, "o-", color=colour, label=channel)
        output = [result.paper.rms_arcsec, result.corrected.rms_arcsec][: len(steps)]
        axes.plot(range(len(output)), output, "s--", color=INK, label="output, fresh turn")
        axes.set_xticks(range(len(steps)), labels)
        axes.set_xlim(-0.4, len(steps) - 0.6)
        axes.set_ylim(0, None)
        axes.set_ylabel("RMS left, arcsec")
        axes.set_title("The ladder", color=INK)
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.98), ncols=3)
        return to_svg(figure)
