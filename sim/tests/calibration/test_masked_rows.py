"""Tests that masked rows of a set are not used, and that the stated properties of the index are
used."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.calibration import CalibrationSettings, CaptureRefusedError, calibrate
from arctrue.measurement import MeasurementSet

from .synthetic import COUNTS, Disc, capture_of, polygon_of, set_of, turn_angles

DISC = Disc({1: (95.0, 0.4), 2: (0.8, 2.0)})
SPIKES = np.array([100, 101, 2500, 4000])


def spoiled(masked: bool) -> MeasurementSet:
    random = np.random.default_rng(3)
    heads = DISC.heads(turn_angles(3000, 2), 0.05, random)
    heads[1, SPIKES] += 400_000
    made = set_of(DISC, capture_of([heads]), polygon_of(DISC, 0.05, random))
    assert made.capture is not None
    assert made.reference is not None
    error = made.reference.error_arcsec.copy()
    error[7] += 3600.0
    rows, stations = np.zeros(6000, bool), np.zeros(error.size, bool)
    rows[SPIKES], stations[7] = masked, masked
    return replace(
        made,
        capture=replace(made.capture, mask=rows),
        reference=replace(made.reference, error_arcsec=error, mask=stations),
    )


def test_masked_rows_are_not_used() -> None:
    with pytest.raises(CaptureRefusedError, match="jump"):
        calibrate(spoiled(masked=False))
    found = calibrate(spoiled(masked=True))
    assert found.turns[0].masked == SPIKES.size
    assert found.turns[0].samples == 6000 - SPIKES.size
    # Written as a function of the reading instead of the angle, the error differs at order 2 by up
    # to (95″)²/2 = 0.022″.
    assert found.estimate.amplitude_arcsec[:2] == pytest.approx([95.0, 0.8], abs=0.025)
    assert found.comparison is not None
    assert np.abs(found.comparison.after_arcsec).max() < 0.3
    assert found.objections == ()


def test_the_transform_needs_every_sample() -> None:
    with pytest.raises(ValueError, match=r"4 samples are masked.*least_squares"):
        calibrate(spoiled(masked=True), CalibrationSettings(method="fourier"))


def test_a_jump_next_to_a_masked_row_is_still_found() -> None:
    made = spoiled(masked=True)
    assert made.capture is not None
    heads = made.capture.head2_counts.copy()
    heads[2502:] += 20 * 5592
    with pytest.raises(CaptureRefusedError, match="sample 2502: a jump"):
        calibrate(replace(made, capture=replace(made.capture, head2_counts=heads)))


def test_a_stated_repeatability_of_the_index_counts() -> None:
    """A standard deviation of 3 counts for one head gives 3·√2 counts for the difference of two
    heads that detect the index at the same place."""
    made = spoiled(masked=True)
    table = replace(made.table, index_detection_arcsec=0.0, index_repeatability_counts=3.0)
    estimate = calibrate(replace(made, table=table)).estimate
    expected = 3.0 * np.sqrt(2.0) * 2.0 * np.pi / COUNTS
    assert estimate.u_head_separation_rad == pytest.approx(expected, rel=1e-9)
