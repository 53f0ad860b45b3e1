"""Prints the runs of a set on the terminal."""

from __future__ import annotations

import math

import numpy as np

from arctrue.base.figures import figure
from arctrue.base.runs import run_spans
from arctrue.base.units import ARCSEC_PER_TURN
from arctrue.cli._loaded_set import console
from arctrue.cli._tables import number, table
from arctrue.measurement import Capture, MeasurementSet, Reference

SHOWN_RUNS = 12


def print_runs(measurement: MeasurementSet) -> None:
    """Print one table for the capture and one table for the reference, with one row for each of the
    first SHOWN_RUNS runs."""
    for part in (measurement.capture, measurement.reference):
        if part is not None:
            _print(part, float(measurement.table.counts_per_rev or 1))


def _print(part: Capture | Reference, counts_per_rev: float) -> None:
    if isinstance(part, Capture):
        label, what = "capture", "R₂ − R₁"
        angle_deg = part.head1_counts / counts_per_rev * 360.0
        value = (part.head2_counts - part.head1_counts) / counts_per_rev * ARCSEC_PER_TURN
    else:
        label, what = "reference", "error"
        angle_deg, value = part.target_deg, part.error_arcsec
    run = np.zeros(value.size, dtype=np.int64) if part.run is None else part.run
    headings = ("run", "rows", "from °", "to °", "seconds", "°C", f"{what}\nmean ″", "σ\n″")
    grid = table(f"{label}: {value.size:,} rows", *map(number, headings))
    spans = run_spans(run)
    for start, end in spans[:SHOWN_RUNS]:
        seconds = math.nan if part.time_s is None else part.time_s[end - 1] - part.time_s[start]
        celsius = math.nan if part.temperature_c is None else part.temperature_c[start:end].mean()
        grid.add_row(
            str(run[start]),
            f"{end - start:,}",
            figure(angle_deg[start], 3),
            figure(angle_deg[end - 1], 3),
            figure(seconds, 1),
            figure(celsius, 1),
            figure(value[start:end].mean(), 3),
            figure(value[start:end].std(), 3),
        )
    console.print(grid)
    if len(spans) > SHOWN_RUNS:
        console.print(f"and {len(spans) - SHOWN_RUNS} more runs")
