"""What the model leaves over the angle, a line a run."""

from __future__ import annotations

import numpy as np

from arctrue.report.charts.bins import turn_group
from arctrue.report.charts.chart import ARCSEC, Axis, Chart, HeatMap, Panel, angle_axis
from arctrue.report.examined import Examined
from arctrue.workbench.observations import CaptureRows

_BINS = 72


def heat_map(examined: Examined) -> Chart:
    """Means each five degrees; runs of the capture, cycles (else runs) of the reference."""
    panels = []
    for channel in examined.channels:
        rows, left = examined.rows(channel), examined.left(channel)
        if isinstance(rows, CaptureRows) or rows.cycle is None:
            word, label = "run", rows.run
        else:
            word, label = "cycle", rows.cycle
        names, line = np.unique(label, return_inverse=True)
        cell = line * _BINS + turn_group(examined.angle_rad(channel), _BINS)
        size = names.size * _BINS
        count = np.bincount(cell, minlength=size)
        sums = np.bincount(cell, left - left.mean(), size)
        mean = np.where(count > 0, sums / np.maximum(count, 1), np.nan).reshape(-1, _BINS)
        centres = (np.arange(_BINS) + 0.5) * 360.0 / _BINS
        every = max(-(-names.size // 12), 1)
        ticks = [(float(place), str(int(names[place]))) for place in range(0, names.size, every)]
        layer = HeatMap(centres, np.arange(names.size, dtype=np.float64), mean, "mean", ARCSEC)
        panels.append(
            Panel(
                angle_axis(),
                Axis(word, ticks=ticks),
                [layer],
                f"{channel.capitalize()}: angle × {word}",
            )
        )
    words = "Mean of what the model leaves over the angle, one line a run."
    return Chart("heat_map", words, panels, panel_height=2.2)
