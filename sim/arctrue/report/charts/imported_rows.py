"""Draws the rows of an imported set before any model is fitted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.base.units import arcsec_per_count
from arctrue.measurement import Capture, MeasurementSet, Reference
from arctrue.report.charts.chart import ARCSEC, COLOURS, Axis, Chart, Curve, Panel

Float = NDArray[np.float64]

_MOST_POINTS = 20_000
"""Only every k-th row of a run is drawn, where k is the number of rows divided by this number,
rounded down. More points would look like a band."""


def imported_rows_chart(measurement: MeasurementSet) -> Chart:
    """Plot the error of head 1 over the target angle, and R₂ − R₁ minus its mean over the angle."""
    panels = []
    if measurement.capture is not None:
        counts_per_rev = measurement.table.counts_per_rev or 1
        panels.append(_capture(measurement.capture, counts_per_rev))
    if measurement.reference is not None:
        panels.append(_reference(measurement.reference))
    return Chart("imported_rows", "The rows of the set before any model.", panels)


def _capture(rows: Capture, counts_per_rev: int) -> Panel:
    angle_deg = np.mod(rows.head1_counts / counts_per_rev, 1.0) * 360.0
    apart = (rows.head2_counts - rows.head1_counts) * arcsec_per_count(counts_per_rev)
    curves = []
    for place, span in enumerate(run_spans(rows.run)):
        inside = slice(*span)
        value = apart[inside] - apart[inside].mean()
        curves.append(_points(place, int(rows.run[span[0]]), angle_deg[inside], value))
    y = Axis("R₂ − R₁ less its mean", ARCSEC)
    return Panel(Axis("head 1", "deg"), y, _named_if_few(curves))


def _reference(rows: Reference) -> Panel:
    run = np.zeros(rows.target_deg.size, dtype=np.int64) if rows.run is None else rows.run
    curves = [
        _points(place, int(run[start]), rows.target_deg[start:end], rows.error_arcsec[start:end])
        for place, (start, end) in enumerate(run_spans(run))
    ]
    y = Axis("reading less reference", ARCSEC)
    return Panel(Axis("target", "deg"), y, _named_if_few(curves))


def _points(place: int, run: int, x: Float, y: Float) -> Curve:
    every = max(x.size // _MOST_POINTS, 1)
    colour = COLOURS[place % len(COLOURS)]
    return Curve(x[::every], y[::every], f"run {run}", colour, kind="points", size=1.5)


def _named_if_few(curves: list[Curve]) -> list[Curve]:
    """Return the curves; they keep their names only if several runs have different colours."""
    if 1 < len(curves) <= len(COLOURS):
        return curves
    return [replace(curve, name="") for curve in curves]
