"""Amplitude of what the model leaves: by order of the turn, by frequency, by period."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from arctrue.report.charts.bins import turn_group
from arctrue.report.charts.chart import (
    ARCSEC,
    CHANNEL_COLOUR,
    COLOURS,
    QUIET,
    Axis,
    Chart,
    Curve,
    Layer,
    Level,
    Panel,
)
from arctrue.report.examined import Examined
from arctrue.runs import run_spans
from arctrue.workbench.observations import CaptureRows

Float = NDArray[np.float64]
Along = Literal["order", "hz", "s"]
ALONG: dict[str, str] = {"order": "order of the turn", "hz": "frequency", "s": "period"}

_TURNS = 2
"""Half orders too: what repeats every second turn."""
_BINS = 8192
"""Over those turns; the mean over a bin is made good at every order."""
HIGHEST_ORDER = 400.0
CHANCE = 0.01
_SHOWN = 1200
_RUNS = 6


def spectrum(examined: Examined, along: Along = "order") -> Chart:
    """Along the order both channels; along frequency or period the runs of the capture."""
    if along == "order":
        panels = [_by_order(examined, channel) for channel in examined.channels]
    else:
        panels = _in_time(examined, along)
    words = f"Amplitude of what the model leaves by {ALONG[along]}."
    return Chart("spectrum", words, panels, panel_height=2.5)


def amplitude_by_order(angle_rad: Float, left: Float, highest: float) -> tuple[Float, Float]:
    """Orders ½, 1, … up to ``highest`` and 2·|Σ r·e^(−inθ)|/N, arcseconds, shape (orders,).

    The true sum where rows lie evenly on the turn; else orders leak into one another.
    """
    group = turn_group(angle_rad / _TURNS, _BINS)
    sums = np.bincount(group, left - left.mean(), _BINS)
    found = 2.0 * np.abs(np.fft.rfft(sums)) / max(left.size, 1)
    order = np.arange(found.size) / _TURNS
    kept = (order > 0.0) & (order <= highest)
    return order[kept], found[kept] / np.sinc(order[kept] * _TURNS / _BINS)


def _by_order(examined: Examined, channel: str) -> Panel:
    rows = examined.rows(channel)
    angle, left = examined.angle_rad(channel), examined.left(channel)
    stations = np.unique(np.round(np.mod(np.degrees(angle), 360.0), 3)).size
    highest = HIGHEST_ORDER
    if isinstance(rows, CaptureRows):
        a_turn = left.size / max(float(np.ptp(angle)) / (2.0 * np.pi), 1.0) / max(rows.runs, 1)
        highest = min(highest, a_turn / 2.0)
    else:
        highest = min(highest, stations / 2.0)
    order, amplitude = amplitude_by_order(angle, left, max(highest, 1.0))
    noise = examined.model.history[-1].noise_arcsec.get(channel, 0.0)
    chance = 2.0 * noise * np.sqrt(np.log(order.size / CHANCE) / max(left.size, 1))
    colour = CHANNEL_COLOUR[channel]
    layers: list[Layer] = [
        Curve(order, amplitude, "what is left", colour, kind="both", width=0.9, size=2.5),
        Level(chance, f"white noise alone exceeds this somewhere in {CHANCE:.0%} of sets"),
    ]
    x = Axis("order, cycles a turn", logarithmic=order.size > 60)
    return Panel(
        x, Axis("amplitude", ARCSEC), layers, f"{channel.capitalize()}: orders of the turn"
    )


def _in_time(examined: Examined, along: Along) -> list[Panel]:
    rows = examined.observations.capture
    if rows is None:
        return []
    left = examined.left("capture")
    layers: list[Layer] = []
    for place, (start, end) in enumerate(run_spans(rows.run)[:_RUNS]):
        found = _periodogram(rows.time_s[start:end], left[start:end])
        if found is None:
            continue
        hz, amplitude = _thinned(*found)
        layers.append(
            Curve(
                hz if along == "hz" else 1.0 / hz,
                amplitude,
                f"run {int(rows.run[start])}",
                COLOURS[place % len(COLOURS)],
                width=1.0,
            )
        )
    unit = "Hz" if along == "hz" else "s"
    title = f"Capture: what is left in each run by {ALONG[along]}"
    if not layers:
        layers = [Level(0.0, "rows are not evenly spaced in time", QUIET)]
        return [Panel(Axis(ALONG[along], unit), Axis("amplitude", ARCSEC), layers, title)]
    x = Axis(ALONG[along], unit, logarithmic=True)
    return [Panel(x, Axis("amplitude", ARCSEC), layers, title)]


def _periodogram(time_s: Float, left: Float) -> tuple[Float, Float] | None:
    """Frequencies and amplitudes of one run; None where its rows are too few."""
    if time_s.size < 8:
        return None
    step = float(np.median(np.diff(time_s)))
    if step <= 0.0:
        return None
    even = np.arange(time_s[0], time_s[-1] + 0.5 * step, step)
    values = np.interp(even, time_s, left - left.mean())
    amplitude = 2.0 * np.abs(np.fft.rfft(values)) / values.size
    hz = np.fft.rfftfreq(values.size, step)
    return np.asarray(hz[1:], dtype=np.float64), np.asarray(amplitude[1:], dtype=np.float64)


def _thinned(hz: Float, amplitude: Float) -> tuple[Float, Float]:
    """The largest amplitude of each of many equal steps of log f: no line is lost."""
    if hz.size <= _SHOWN:
        return hz, amplitude
    place = np.log(hz / hz[0]) / np.log(hz[-1] / hz[0]) * (_SHOWN - 1)
    group = place.astype(np.int64)
    starts = np.flatnonzero(np.diff(group, prepend=-1))
    best = np.array(
        [
            start + int(np.argmax(part))
            for start, part in zip(starts, np.split(amplitude, starts[1:]), strict=True)
        ]
    )
    return hz[best], amplitude[best]
