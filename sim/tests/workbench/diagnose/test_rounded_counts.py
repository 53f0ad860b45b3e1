"""Tests of encoders whose counts are coarser than their noise, so that rounding errors repeat."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of

from arctrue.measurement import Capture, MeasurementSet, Reference, Table

COUNTS = 1 << 20
COUNT_ARCSEC = 1_296_000.0 / COUNTS
ALPHA_DEG = 33.0


def _error(angle_rad: np.ndarray) -> np.ndarray:
    return np.asarray(40.0 * np.cos(angle_rad + 0.4) + 5.0 * np.cos(2.0 * angle_rad))


def _capture() -> MeasurementSet:
    """Make two runs of five turns that meet the same 240 angles on every turn, and a polygon.

    The noise of a head is 0.13″, a tenth of a count.
    """
    random = np.random.default_rng(4)
    a_turn, turns = 240, 5
    angle = np.arange(a_turn * turns) * 2.0 * np.pi / a_turn + 0.1
    angle = np.concatenate([angle, angle[::-1]])
    heads = []
    for place in (0.0, np.radians(ALPHA_DEG)):
        error = _error(angle + place) + random.normal(0.0, 0.13, angle.size)
        reading = np.degrees(angle + place) * 3600.0 + error
        heads.append(np.round(reading / COUNT_ARCSEC).astype(np.int64))
    rows = a_turn * turns
    capture = Capture(
        run=np.repeat([0, 1], rows),
        time_s=np.concatenate([np.arange(rows), rows + 200.0 + np.arange(rows)]) * 0.02,
        head1_counts=heads[0],
        head2_counts=heads[1],
    )
    up = np.arange(24) * 15.0
    target = np.tile(np.concatenate([up, up[::-1]]), 5)
    reference = Reference(
        target,
        _error(np.radians(target)) + random.normal(0.0, 0.14, target.size),
        time_s=5.0 * np.arange(target.size),
        cycle=np.repeat(np.arange(5), 48),
        direction=np.tile(np.repeat([1, -1], 24), 5),
        faces=24,
    )
    table = Table(counts_per_rev=COUNTS, head_separation_deg=ALPHA_DEG, grating_lines=16_384)
    return MeasurementSet(table, capture, reference, title="coarse counts")


@pytest.mark.large
def test_rounding_that_repeats_with_the_angle_is_no_unknown_effect() -> None:
    """Two rounded heads differ by √(2/12) = 0.41 counts RMS, below the negligible half count."""
    found = diagnosis_of(_capture())
    assert found.verdict == "adequate"


def _stations(seed: int) -> MeasurementSet:
    """Make a log of a 12-bit encoder: 200 readings per turn, three turns up and three down.

    The upward and downward readings differ by 2 to 6 counts.

    The readings of a station in one direction differ by 0 or one count, and the rounding error
    changes from station to station.
    """
    random = np.random.default_rng(seed)
    counts = 4096
    count = 1_296_000.0 / counts
    up = np.arange(600) * 1.8 + 0.3
    target = np.concatenate([up, up[::-1]])
    direction = np.repeat([1, -1], up.size)
    angle = np.radians(target)
    error = 2000.0 * np.cos(angle + 1.0) + 2.0 * count * direction
    error = error * (1.0 + 0.5 * np.cos(angle)) + random.normal(0.0, 100.0, target.size)
    reading = np.round((target * 3600.0 + error) / count)
    reference = Reference(
        target,
        reading * count - target * 3600.0,
        direction=direction,
        head1_counts=reading.astype(np.int64),
    )
    return MeasurementSet(Table(counts_per_rev=counts), None, reference, title="steps")


@pytest.mark.large
def test_readings_that_differ_by_one_count_are_no_outliers() -> None:
    for seed in range(3):
        found = diagnosis_of(_stations(seed))
        assert found.verdict != "bad_data"
        assert not found.observations.masked


def test_rounding_of_a_log_without_noise_is_no_unknown_effect() -> None:
    """One turn of 2,000 readings of 4,096 counts, without noise: the residual of the orders 1 and 2
    is the rounding, 1/√12 of a count RMS, below the negligible half count."""
    counts = 4096
    target = np.arange(2000) * 0.18
    angle = np.radians(target)
    reading = target + (1800.0 * np.cos(angle - 0.35) + 500.0 * np.cos(2.0 * angle - 0.9)) / 3600.0
    shown = np.round(reading / 360.0 * counts).astype(np.int64)
    reference = Reference(target, (shown * 360.0 / counts - target) * 3600.0, head1_counts=shown)
    found = diagnosis_of(MeasurementSet(Table(counts_per_rev=counts), None, reference))
    assert found.channels["reference"].residual_rms_arcsec < 0.5 * 1_296_000.0 / counts
    assert found.verdict in ("adequate", "cannot_tell")
