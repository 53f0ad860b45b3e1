"""Draws the RMS error after each step of the model, next to the noise floor of the repeats."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from arctrue.report.charts.chart import (
    ARCSEC,
    CHANNEL_COLOUR,
    QUIET,
    Axis,
    Chart,
    Curve,
    Layer,
    Level,
    Panel,
)
from arctrue.workbench.model.model import HistoryStep
from arctrue.workbench.model.noise_floor import with_one_floor

Float = NDArray[np.float64]


def _noise_floor(place: Float, noise: Float) -> list[Layer]:
    """Return the line of the noise: one level if all steps have the same noise, otherwise a
    curve."""
    known = noise[np.isfinite(noise)]
    if not known.size:
        return []
    if np.all(known == known[0]):
        return [Level(float(known[0]), "noise", QUIET, "dot")]
    return [Curve(place, noise, "noise", QUIET, dash="dot")]


def ladder(history: Sequence[HistoryStep]) -> Chart:
    """Draw the RMS error of each channel after every step, for fitted and for held-out rows, and
    the noise floor."""
    history = with_one_floor(history)
    channels = [name for name in CHANNEL_COLOUR if any(name in step.rms_arcsec for step in history)]
    place = np.arange(len(history), dtype=np.float64)
    ticks = [(float(number), _name(step, number)) for number, step in enumerate(history)]
    panels = []
    for channel in channels:
        colour = CHANNEL_COLOUR[channel]
        fitted = _of(history, "rms_arcsec", channel)
        held_out = _of(history, "heldout_rms_arcsec", channel)
        noise = _of(history, "noise_arcsec", channel)
        layers: list[Layer] = [
            *_noise_floor(place, noise),
            Curve(place, fitted, "fitted", colour, kind="both", size=6, values_shown=True),
            Curve(place, held_out, "held out", colour, kind="points", marker="hollow", size=9),
        ]
        every = np.concatenate([fitted, held_out, noise])
        every = every[np.isfinite(every) & (every > 0.0)]
        reach = (float(every.min()) / 1.25, float(every.max()) * 1.35) if every.size else None
        panels.append(
            Panel(
                Axis("step", ticks=ticks, reach=(-0.5, max(len(history), 2) - 0.5)),
                Axis("RMS of the residual", ARCSEC, logarithmic=every.size > 0, reach=reach),
                layers,
                channel.capitalize(),
            )
        )
    changes = "; ".join(
        f"{name} from {history[0].rms_arcsec[name]:.3f}″ to {history[-1].rms_arcsec[name]:.3f}″"
        for name in channels
        if name in history[0].rms_arcsec and name in history[-1].rms_arcsec
    )
    return Chart("ladder", f"How the error fell: {changes}.", panels, columns=2, panel_height=3.2)


def _name(step: HistoryStep, number: int) -> str:
    effect = "the first model" if step.action == "fit" else step.effect.replace("_", " ")
    return f"{number + 1} {step.action}\n{effect}"


def _of(history: Sequence[HistoryStep], figure: str, channel: str) -> Float:
    return np.array([getattr(step, figure).get(channel, np.nan) for step in history])
