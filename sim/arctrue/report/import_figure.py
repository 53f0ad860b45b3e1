"""The first picture of an imported set: what was read, before any model."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from arctrue.base.runs import run_spans
from arctrue.base.units import arcsec_per_count
from arctrue.measurement import MeasurementSet
from arctrue.report.png import COLOURS, plain_axes, png_figure, save_png

NAME = "first_plot.png"
MOST_POINTS = 20_000
"""Drawn of a run; more would be one black band."""


def plot_imported(measurement: MeasurementSet, folder: Path) -> Path:
    """The error of head 1 against the target, and R₂ − R₁ less its mean against the angle."""
    capture, reference = measurement.capture, measurement.reference
    panels = [part for part in (capture, reference) if part is not None]
    figure = png_figure(8.6, 3.2 * len(panels))
    axes_of = np.atleast_1d(figure.subplots(len(panels), 1))
    for axes, part in zip(axes_of, panels, strict=True):
        plain_axes(axes)
        run = part.run if part.run is not None else np.zeros(part_size(part), dtype=np.int64)
        for number, (start, end) in enumerate(run_spans(run)):
            rows = slice(start, end, max((end - start) // MOST_POINTS, 1))
            if part is capture:
                assert capture is not None
                counts = measurement.table.counts_per_rev or 1
                angle_deg = np.mod(capture.head1_counts[rows] / counts, 1.0) * 360.0
                apart = capture.head2_counts[rows] - capture.head1_counts[rows]
                value = (apart - apart.mean()) * arcsec_per_count(counts)
            else:
                assert reference is not None
                angle_deg, value = reference.target_deg[rows], reference.error_arcsec[rows]
            colour = COLOURS[number % len(COLOURS)]
            axes.plot(angle_deg, value, ".", markersize=2, color=colour, label=f"run {run[start]}")
        name = "R₂ − R₁ less its mean" if part is capture else "reading less reference"
        axes.set_xlabel("head 1, °" if part is capture else "target, °")
        axes.set_ylabel(f"{name}, ″")
        if 1 < len(run_spans(run)) <= len(COLOURS):
            axes.legend(fontsize=8, markerscale=4)
    return save_png(figure, folder, NAME)


def part_size(part: object) -> int:
    """How many rows a capture or a reference has."""
    rows = getattr(part, "time_s", None)
    return int((rows if rows is not None else part.target_deg).size)  # type: ignore[attr-defined]
