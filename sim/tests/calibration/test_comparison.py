"""Tests the comparison of the error before and after a correction, which the bit-true model of the
gateware computes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.calibration import calibrate
from arctrue.calibration.calibration import objections
from arctrue.calibration.comparison import compare, extent, reading_counts
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.extension import Conditions
from arctrue.measurement import MeasurementSet, Reference, Table

from .synthetic import COUNTS, Disc, capture_of, polygon_of, set_of, turn_angles

DISC = Disc({1: (95.0, 0.4), 2: (0.8, 2.0), 5: (0.5, -1.0), 8: (0.3, 1.0)})


def calibrated(noise: float, reference_noise: float):
    random = np.random.default_rng(8)
    heads = [
        DISC.heads(turn_angles(6000, 3), noise, random),
        DISC.heads(turn_angles(6000, 3, direction=-1, start=5.0), noise, random),
    ]
    reference = polygon_of(DISC, reference_noise, random)
    return calibrate(set_of(DISC, capture_of(heads), reference)), reference


def test_after_is_no_larger_than_the_noise_of_the_reference() -> None:
    """The corrected error must not exceed 1.2 times the peak-to-peak noise of the reference; the
    simulated noise has the size of a good table's noise."""
    found, reference = calibrated(0.1, 0.15)
    comparison = found.comparison
    assert comparison is not None
    assert comparison.noise is not None
    assert extent(comparison.before_arcsec).peak_to_peak > 180.0
    after = extent(comparison.after_arcsec)
    assert after.peak_to_peak <= 1.2 * comparison.noise.peak_to_peak
    # numpy subtracts the mean of ten rows at each of the 24 faces; the residual is the noise.
    faces = reference.error_arcsec.reshape(5, 2, 24)
    faces[:, 1] = faces[:, 1, ::-1]
    scatter = faces - faces.mean(axis=(0, 1))
    assert comparison.noise.peak_to_peak == pytest.approx(np.ptp(scatter))


def test_without_noise_what_is_left_is_rounding() -> None:
    comparison = calibrated(0.0, 0.0)[0].comparison
    assert comparison is not None
    # The bound is the sum of half a count for the final rounding and 2 × 0.01″ for the rounding of
    # the two heads' readings in the calibration.
    assert np.abs(comparison.after_arcsec).max() < 0.5 * 1_296_000 / COUNTS + 0.02


def test_the_same_mean_is_taken_off_both() -> None:
    found, reference = calibrated(0.1, 0.15)
    shifted = replace(reference, error_arcsec=reference.error_arcsec + 40.0)
    plain, moved = (compare(r, found.coefficients) for r in (reference, shifted))
    assert moved.before_arcsec == pytest.approx(plain.before_arcsec)
    assert moved.after_arcsec == pytest.approx(plain.after_arcsec)
    assert plain.after_arcsec.mean() == pytest.approx(0.0, abs=1e-9)


def test_no_coefficients_change_nothing() -> None:
    reference = polygon_of(DISC, 0.1, np.random.default_rng(1))
    comparison = compare(reference, Coefficients.zero(COUNTS))
    assert (comparison.before_arcsec == comparison.after_arcsec).all()


def test_reading_without_recorded_counts() -> None:
    reference = Reference(np.array([-90.0, 0.0, 361.0]), np.array([0.0, 1296.0, 0.0]))
    assert reading_counts(reference, 36_000).tolist() == [-9_000, 36, 36_100]
    assert compare(reference, Coefficients.zero(36_000)).noise is None


def test_readings_at_the_turn() -> None:
    """A correction across angle zero is a small angle; the comparison must not report it as nearly
    a turn."""
    coefficients = Coefficients.from_harmonics([1], [1000.0], [0.0], COUNTS)
    reference = Reference(
        np.zeros(3),
        np.array([0.0, 0.0, 1000.0 * 1_296_000 / COUNTS]),
        head1_counts=np.array([0, 5, -3]),
    )
    comparison = compare(reference, coefficients)
    assert np.ptp(comparison.before_arcsec - comparison.after_arcsec) < 2.0


ROUNDING_ARCSEC = 1_296_000 / COUNTS
"""Bound of the rounding: half a count of the reading and half a count of the result."""


def one_lane(order: int, size_arcsec: float) -> Coefficients:
    size_counts = size_arcsec * COUNTS / 1_296_000
    return Coefficients.from_harmonics([order], [size_counts], [0.0], COUNTS, 4)


@pytest.mark.parametrize("modulator", ["direction", "speed", "word_a"])
def test_a_lane_with_a_condition_acts_as_in_the_rows(modulator: str) -> None:
    """A lane that follows the direction corrects ±5″ in both directions. A lane whose condition the
    rows do not state has no effect, so that its coefficients cause no objection."""
    target, direction = np.tile(np.arange(24) * 15.0, 2), np.repeat([1, -1], 24)
    error = 5.0 * direction * np.cos(np.radians(target))
    reference = Reference(target, error, direction=direction)
    conditions = Conditions(16 * COUNTS // 360, 4, 90.0)
    coefficients = replace(
        one_lane(1, 5.0),
        extension=Extension(conditions=conditions, modulators=((0, modulator),)),
    )
    after = compare(reference, coefficients).after_arcsec
    left = 0.0 if modulator == "direction" else error - error.mean()
    assert np.abs(after - left).max() < ROUNDING_ARCSEC
    made = MeasurementSet(Table(counts_per_rev=COUNTS), reference=reference, title="condition")
    assert objections(made, coefficients) == []


def test_a_lane_of_a_real_order_has_the_turn_of_the_row() -> None:
    target = np.arange(-48, 96) * 15.0
    error = 5.0 * np.cos(71.4 * np.radians(target))
    coefficients = one_lane(0, 5.0).with_real_orders({0: 71.4})
    after = compare(Reference(target, error), coefficients).after_arcsec
    # The reading differs from the target by up to 5″, which is 2.4e-5 rad. Over this angle the wave
    # changes by up to 71.4 · 2.4e-5 · 5″.
    assert np.abs(after).max() < 2.0 * ROUNDING_ARCSEC + 71.4 * 25.0 * np.pi / 648_000.0
