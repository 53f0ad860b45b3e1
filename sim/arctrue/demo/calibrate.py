"""What the processor of the demo works out from a capture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.calibration import CalibrationSettings, calibrate
from arctrue.demo.settings import DemoSettings
from arctrue.gateware.coefficients import Coefficients
from arctrue.measurement import Capture, MeasurementSet, Table

HEAD_SEPARATION_DEG = 33.0


@dataclass(frozen=True, slots=True)
class FoundHarmonics:
    """The coefficients to load, and what they came from, one entry a lane in use."""

    coefficients: Coefficients
    orders: list[int]
    amplitudes_counts: list[float]
    phases_rad: list[float]
    uncertainties_counts: list[float]


def calibrate_capture(counts: NDArray[np.int64], settings: DemoSettings) -> FoundHarmonics:
    """Calibrate from the counts of both heads, shape (2, n), as the capture memory gave them.

    Raises CaptureRefused for a capture that cannot be used.
    """
    samples = counts.shape[1]
    measurement = MeasurementSet(
        table=Table(
            counts_per_rev=settings.counts_per_rev, head_separation_deg=HEAD_SEPARATION_DEG
        ),
        capture=Capture(
            run=np.zeros(samples, dtype=np.int64),
            time_s=np.arange(samples) * settings.sample_period_clocks / settings.clock_hz,
            head1_counts=counts[0],
            head2_counts=counts[1],
            clock_hz=settings.clock_hz,
        ),
        title="capture of the demo",
    )
    found = calibrate(
        measurement, CalibrationSettings(lanes=settings.lanes, most_order=settings.fitted_orders)
    )
    applied = np.array([verdict.applied for verdict in found.verdicts], dtype=bool)
    estimate = found.estimate
    return FoundHarmonics(
        coefficients=found.coefficients,
        orders=estimate.orders[applied].tolist(),
        amplitudes_counts=(estimate.amplitude_arcsec[applied] / settings.arcsec_per_count).tolist(),
        phases_rad=estimate.phase_rad[applied].tolist(),
        uncertainties_counts=(
            estimate.u_amplitude_arcsec[applied] / settings.arcsec_per_count
        ).tolist(),
    )
