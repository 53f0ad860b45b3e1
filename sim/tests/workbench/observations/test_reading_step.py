"""Tests that readings that an encoder rounds to its counts are no outliers, and that real outliers
among them are found."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import Reference
from arctrue.workbench.observations.outliers.reference_rows import reference_outliers
from arctrue.workbench.observations.outliers.single_rows import MOST_SHARE
from arctrue.workbench.observations.reading_step import reading_step

Float = NDArray[np.float64]
COUNT_ARCSEC = 1_296_000.0 / 16_384


def _rounded(target_deg: Float, error_arcsec: Float, step_arcsec: float) -> Float:
    """Return the errors of rounded readings, as a file with one decimal stores them."""
    reading = np.round((3600.0 * target_deg + error_arcsec) / step_arcsec) * step_arcsec
    return np.asarray(np.round(reading - 3600.0 * target_deg, 1))


def _turns(seed: int) -> tuple[Float, Float]:
    """Return targets and errors of six turns of 300 stations: 20″ of noise, a count of 79″."""
    rng = np.random.default_rng(seed)
    target = np.tile(np.arange(300) * 1.2, 6)
    error = 700.0 * np.cos(np.radians(target) + 1.0) + 90.0 * np.cos(np.radians(4.0 * target))
    return target, _rounded(target, error + 20.0 * rng.normal(size=target.size), COUNT_ARCSEC)


def _reference(target_deg: Float, error_arcsec: Float, pass_rows: int) -> Reference:
    rows = np.arange(target_deg.size)
    return Reference(
        target_deg=target_deg,
        error_arcsec=error_arcsec,
        run=rows // pass_rows,
        time_s=rows.astype(float),
    )


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("count_arcsec", [None, COUNT_ARCSEC])
def test_rounded_readings_of_stations_are_no_outliers(
    seed: int, count_arcsec: float | None
) -> None:
    target, error = _turns(seed)
    # No reading is farther from the error than half a count and four standard deviations.
    found, _ = reference_outliers(_reference(target, error, 300), count_arcsec)
    assert not found.any()


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_rounded_readings_of_a_sector_with_stops_are_no_outliers(seed: int) -> None:
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 8000.0, 10.0)
    way = np.clip(1.5 * np.sin(2.0 * np.pi * time / 8000.0), -1.0, 1.0)
    target = 200.0 + 30.0 * way
    error = _rounded(target, 144.0 * rng.normal(size=time.size), 360.0)
    rows = _reference(np.round(target, 3), np.round(error), time.size)
    found, _ = reference_outliers(rows)
    # 144″ of noise and a rounding of up to 180″ leave no reading that is wrong.
    assert found.mean() < 0.2 * MOST_SHARE


def test_a_wrong_reading_among_rounded_readings_is_an_outlier() -> None:
    target, error = _turns(4)
    error[700] += 8 * COUNT_ARCSEC
    found, _ = reference_outliers(_reference(target, error, 300), COUNT_ARCSEC)
    assert np.flatnonzero(found).tolist() == [700]


@pytest.mark.parametrize("count_arcsec", [None, COUNT_ARCSEC])
def test_the_step_of_rounded_readings_is_the_count(count_arcsec: float | None) -> None:
    # The file rounds each error to 0.1″; the readings extend over 16,384 counts.
    assert reading_step(*_turns(5), count_arcsec) == pytest.approx(COUNT_ARCSEC, rel=1e-6)


def test_readings_that_are_not_rounded_have_no_step() -> None:
    target = np.tile(np.arange(300) * 1.2, 6)
    noise = np.random.default_rng(6).normal(size=target.size)
    assert reading_step(target, np.round(20.0 * noise, 1), COUNT_ARCSEC) == 0.0
    # A display of 0.5″ at stations of whole steps is the step of the errors, not of the readings.
    assert reading_step(target, np.round(2.0 * noise) / 2.0) == 0.0
