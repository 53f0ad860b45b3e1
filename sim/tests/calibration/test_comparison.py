"""Tests the comparison of the error before and after a correction, which the bit-true model of the
gateware computes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.calibration import calibrate
from arctrue.calibration.comparison import compare, extent, reading_counts
from arctrue.gateware.coefficients import Coefficients
from arctrue.measurement import Reference

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
