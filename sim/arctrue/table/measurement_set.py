"""Simulated runs as a measurement set, so that everything downstream takes them for real ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from arctrue.measurement import Capture, MeasurementSet, Reference, Table
from arctrue.table.capture import ReferenceRun, SampledRun
from arctrue.table.rotary_table import DISC_RADIUS_M, HEAD_SEPARATION_RAD, RotaryTable

GRATING_LINES = 16384
"""Lines of the paper's disc."""


def measurement_set(
    table: RotaryTable,
    runs: Sequence[SampledRun] = (),
    reference: ReferenceRun | None = None,
    *,
    title: str = "simulated rotary table",
    pause_s: float = 1.0,
    faces: int = 24,
    reference_uncertainty_arcsec: float = 0.15,
    clock_hz: float = 100e6,
) -> MeasurementSet:
    """Put runs one after another, ``pause_s`` between them, and a polygon run beside them."""
    capture = None
    if runs:
        starts, start = [], 0.0
        for run in runs:
            starts.append(start)
            start += float(run.time_s[-1]) + pause_s
        capture = Capture(
            run=np.repeat(np.arange(len(runs)), [run.time_s.size for run in runs]),
            time_s=np.concatenate(
                [run.time_s + start for run, start in zip(runs, starts, strict=True)]
            ),
            head1_counts=np.concatenate([run.counts[0] for run in runs]),
            head2_counts=np.concatenate([run.counts[1] for run in runs]),
            clock_hz=clock_hz,
        )
    measured = None
    if reference is not None:
        measured = Reference(
            target_deg=reference.target_deg,
            error_arcsec=reference.error_arcsec,
            run=np.zeros(reference.target_deg.size, dtype=np.int64),
            time_s=reference.time_s,
            cycle=reference.cycle,
            direction=reference.direction,
            head1_counts=reference.head1_counts,
            instrument="simulated polygon and autocollimator",
            faces=faces,
            standard_uncertainty_arcsec=reference_uncertainty_arcsec,
        )
    return MeasurementSet(
        table=Table(
            counts_per_rev=table.counts_per_rev,
            grating_lines=GRATING_LINES if table.counts_per_rev % GRATING_LINES == 0 else None,
            disc_diameter_mm=2e3 * DISC_RADIUS_M,
            head_separation_deg=float(np.rad2deg(HEAD_SEPARATION_RAD)),
        ),
        capture=capture,
        reference=measured,
        title=title,
    )
