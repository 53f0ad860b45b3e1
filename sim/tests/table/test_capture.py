"""Sampled runs and polygon runs of the simulated table."""

from pathlib import Path

import numpy as np
import pytest

from arctrue.measurement import read_measurement_set, write_measurement_set
from arctrue.table import (
    DiscEccentricity,
    GraduationHarmonics,
    Motion,
    RotaryTable,
    TableState,
    measure_with_polygon,
    measurement_set,
    sample,
    two_heads,
)

ARCSEC = np.deg2rad(1 / 3600)
TABLE = RotaryTable(
    two_heads(),
    (DiscEccentricity(40e-6, 1.0), GraduationHarmonics((3,), (2 * ARCSEC,), (0.5,))),
    noise_rad=0.1 * ARCSEC,
)


def test_a_turn_at_the_papers_speed_has_12000_steps_of_108_arcsec() -> None:
    run = sample(TABLE, Motion.steady(np.deg2rad(30.0), 12.0), 1e-3, np.random.default_rng(0))
    assert run.counts.shape == (2, 12_001)
    step_arcsec = np.diff(run.counts[0]) * TABLE.count_rad / ARCSEC
    # 108″, ±0.08″ for the slope of the eccentricity, five σ of the difference of two readings
    assert np.abs(step_arcsec - 108).max() < 0.08 + 0.08 + 5 * np.sqrt(2) * 0.1
    clean = TABLE.reading_rad(1, TableState.at_rest(run.true_angle_rad)) / TABLE.count_rad
    scatter = run.counts[1] + 0.5 - clean
    expected = np.hypot(0.1 * ARCSEC / TABLE.count_rad, np.sqrt(1 / 12))
    assert scatter.std() == pytest.approx(expected, rel=0.04)
    assert abs(scatter.mean()) < 5 * expected / np.sqrt(scatter.size)


def test_no_random_source_no_noise() -> None:
    motion = Motion.steady(1.0, 1.0)
    first, second = sample(TABLE, motion, 1e-2), sample(TABLE, motion, 1e-2)
    np.testing.assert_array_equal(first.counts, second.counts)
    with pytest.raises(ValueError, match="must be positive"):
        sample(TABLE, motion, 0.0)


def test_polygon_measures_the_error_of_head_one() -> None:
    random = np.random.default_rng(3)
    run = measure_with_polygon(TABLE, cycles=10, reference_noise_arcsec=0.15, random=random)
    assert run.error_arcsec.shape == (480,)
    assert run.direction[:24].tolist() == [1] * 24
    assert run.direction[24:48].tolist() == [-1] * 24
    assert run.cycle[47:49].tolist() == [0, 1]
    # the station is at the target as head 1 reads it, to its noise and a count
    off_arcsec = run.head1_counts * TABLE.count_rad / ARCSEC - run.target_deg * 3600
    assert np.abs(off_arcsec).max() < 0.08 + 0.11 + 5 * 0.1
    faces = np.deg2rad(run.target_deg)
    # ε at the true angle, which is the target less ε: worked out by the fixed point
    angle = faces.copy()
    for _ in range(20):
        angle += faces - TABLE.reading_rad(0, TableState.at_rest(angle))
    expected_arcsec = (faces - angle) / ARCSEC
    scatter = run.error_arcsec - expected_arcsec
    assert scatter.std() == pytest.approx(np.hypot(0.15, 0.1), rel=0.2)
    assert np.ptp(expected_arcsec) > 250


def test_measurement_set_is_read_back_as_simulated(tmp_path: Path) -> None:
    random = np.random.default_rng(8)
    speed = np.deg2rad(30.0)
    runs = [
        sample(TABLE, Motion.steady(speed * d, 13.0, start_rad=-d), 0.01, random) for d in (1, -1)
    ]
    polygon = measure_with_polygon(TABLE, cycles=2, random=random)
    write_measurement_set(tmp_path, measurement_set(TABLE, runs, polygon, title="two runs"))
    again = read_measurement_set(tmp_path)
    assert again.warnings == ()
    assert again.table.counts_per_rev == TABLE.counts_per_rev
    assert again.table.head_separation_deg == pytest.approx(33.0)
    capture, reference = again.capture, again.reference
    assert capture is not None
    assert reference is not None
    np.testing.assert_array_equal(
        capture.head2_counts, np.concatenate([run.counts[1] for run in runs])
    )
    assert np.all(np.diff(capture.time_s) > 0)
    assert np.unique(capture.run).tolist() == [0, 1]
    np.testing.assert_allclose(reference.error_arcsec, polygon.error_arcsec, atol=1e-6)
    # head separation: the mean of R₂ − R₁ over whole turns, (a²/2)·sin α and a count beside it
    turn = capture.run == 0
    difference = (capture.head2_counts - capture.head1_counts)[turn][:1200].mean()
    assert np.rad2deg(difference * TABLE.count_rad) == pytest.approx(33.0, abs=0.5 / 3600)
