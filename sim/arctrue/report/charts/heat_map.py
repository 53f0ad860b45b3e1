"""Draws the residual over the angle as a map of colours, with one line per run."""

from __future__ import annotations

import numpy as np

from arctrue.report.analysis import Analysis
from arctrue.report.charts.angle_window import AngleWindow
from arctrue.report.charts.chart import ARCSEC, Axis, Chart, HeatMap, Panel
from arctrue.workbench.observations import CaptureRows

_BINS = 72


def heat_map(analysis: Analysis) -> Chart:
    """Draw the mean residual in each five degrees of the turn, or in each of 72 parts of an arc.

    A line is a run of the capture or a cycle of the reference; without cycles, a line is a run of
    the reference.
    """
    panels = []
    for channel in analysis.observations.channels:
        rows, left = analysis.rows(channel), analysis.left(channel)
        if isinstance(rows, CaptureRows) or rows.cycle is None:
            word, label = "run", rows.run
        else:
            word, label = "cycle", rows.cycle
        names, line = np.unique(label, return_inverse=True)
        angle = analysis.angle_rad(channel)
        window = AngleWindow.over(angle)
        cell = line * _BINS + window.group(angle, _BINS)
        size = names.size * _BINS
        count = np.bincount(cell, minlength=size)
        sums = np.bincount(cell, left - left.mean(), size)
        mean = np.where(count > 0, sums / np.maximum(count, 1), np.nan).reshape(-1, _BINS)
        every = max(-(-names.size // 12), 1)
        ticks = [(float(place), str(int(names[place]))) for place in range(0, names.size, every)]
        layer = HeatMap(
            window.centres(_BINS), np.arange(names.size, dtype=np.float64), mean, "mean", ARCSEC
        )
        panels.append(
            Panel(
                window.axis(),
                Axis(word, ticks=ticks),
                [layer],
                f"{channel.capitalize()}: angle × {word}",
            )
        )
    words = "Mean residual over the angle, one line per run."
    return Chart("heat_map", words, panels, panel_height=2.2)
