"""Tests the firmware with the core in VHDL: runs the demo with a sixteenth of its counts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.calibration import Calibration, CalibrationSettings, calibrate
from arctrue.measurement import Capture, MeasurementSet, Table
from arctrue.studies.demo.files import DemoFiles
from arctrue.studies.demo.run import run_demo
from arctrue.studies.demo.settings import DemoSettings
from arctrue.table import PinEvents

# The core has one lane fewer than the disc has orders, so the order with the smallest amplitude is
# not corrected; this amplitude is below the limit of the test.
SETTINGS = DemoSettings(counts_per_rev=1 << 12, lanes=3, disc_scale=32.0, sample_period_clocks=20)
HEAD_SEPARATION_DEG = 33.0
PRINTED_DECIMALS = 2e-9
"""Tolerance: two units of the ninth decimal, the last one that the console prints of arcsec and
rad."""


def calibrate_in_numpy(counts: NDArray[np.int64]) -> Calibration:
    """Calibrate with the Python package from a capture with counts (2, n)."""
    samples = counts.shape[1]
    capture = Capture(
        run=np.zeros(samples, dtype=np.int64),
        time_s=np.arange(samples) * SETTINGS.sample_period_clocks / SETTINGS.clock_hz,
        head1_counts=counts[0],
        head2_counts=counts[1],
        clock_hz=SETTINGS.clock_hz,
    )
    table = Table(counts_per_rev=SETTINGS.counts_per_rev, head_separation_deg=HEAD_SEPARATION_DEG)
    return calibrate(
        MeasurementSet(table=table, capture=capture, title="capture of the demo"),
        CalibrationSettings(lanes=SETTINGS.lanes, most_order=SETTINGS.fitted_orders),
    )


@pytest.mark.large
def test_the_firmware_corrects_the_real_core(tmp_path: Path) -> None:
    lines: list[str] = []
    result = run_demo(SETTINGS, tmp_path, lines.append)
    assert result.faults == ()
    count = SETTINGS.arcsec_per_count
    assert result.before.edges_reach_arcsec > 14 * count
    assert result.after.edges_reach_arcsec <= SETTINGS.peak_limit_counts * count
    assert [harmonic.order for harmonic in result.harmonics] == [1, 2, 3]
    assert any("reading a captured turn" in line for line in lines)

    # The console shows the results of the C code; they must equal those of the Python calibration.
    files = DemoFiles(tmp_path)
    reported = result.turns[0]
    counts = np.load(files.capture)
    assert counts.shape == (2, reported.samples)
    assert counts[0, -1] - counts[0, 0] >= SETTINGS.counts_per_rev > counts[0, -2] - counts[0, 0]
    reference = calibrate_in_numpy(counts)
    assert reported.result == "applied"
    assert [h.applied for h in reported.harmonics] == [v.applied for v in reference.verdicts]
    chosen = np.array([h.applied for h in reported.harmonics])
    for values, expected in (
        ([h.amplitude_arcsec for h in reported.harmonics], reference.estimate.amplitude_arcsec),
        ([h.phase_rad for h in reported.harmonics], reference.estimate.phase_rad),
    ):
        np.testing.assert_allclose(
            np.array(values)[chosen], expected[chosen], rtol=0, atol=PRINTED_DECIMALS
        )

    # The estimates of later turns are no improvement, so the firmware keeps the active
    # coefficients.
    assert {turn.result for turn in result.turns[1:]} == {"kept"}
    # The recorded output has no two changes in the same clock.
    assert np.diff(PinEvents.read(files.recorded).clock).min() >= 1
