"""Tests that the diagnosis reports columns of a reference that cannot be right."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of
from sim.tests.workbench.small_sets import measurement_set

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.data_faults import data_faults
from arctrue.workbench.observations.build import observations_of

ROWS = 1200


def _log(*, noise: float = 0.5, amplitude: float = 20.0, display: float = 0.0) -> Reference:
    """Return a log of 1,200 rows over 10°, with a line of 5 periods and noise in arcseconds."""
    random = np.random.default_rng(6)
    time_s = 2.0 * np.arange(1, ROWS + 1) + random.uniform(0.0, 0.3, ROWS)
    target = time_s * 0.0042
    error = amplitude * np.sin(2.0 * np.pi * time_s / 480.0) + random.normal(0.0, noise, ROWS)
    if display:
        error = np.round(error / display) * display
    return Reference(target, error, time_s=time_s, direction=np.ones(ROWS, dtype=np.int64))


def _faults(columns: Reference) -> list[str]:
    return data_faults(observations_of(MeasurementSet(Table(), None, columns)))


def test_good_logs_and_stations_have_no_faults() -> None:
    assert _faults(_log()) == []
    assert data_faults(observations_of(measurement_set())) == []


@pytest.mark.parametrize("drift", [0.0, 0.05])
def test_exchanged_columns_are_bad_data(drift: float) -> None:
    """Exchanged columns are found also if the error drifts, here by 60″, and so changes from one
    end of its range to the other as a motion does. The error column must follow the direction: if
    only the target were noisy, the error would have this noise as well."""
    made = _log()
    made.error_arcsec[:] += drift * np.arange(ROWS)
    swapped = replace(made, target_deg=made.error_arcsec, error_arcsec=made.target_deg)
    found = diagnosis_of(MeasurementSet(Table(), None, swapped))
    assert found.verdict == "bad_data"
    (said,) = _faults(swapped)
    assert said.startswith("reference, row ")
    assert "are the columns target_deg and error_arcsec exchanged" in said


def test_a_direction_that_the_motion_contradicts_is_bad_data() -> None:
    """The table goes up and down, and the column says up in all rows: the log has 599 steps
    down."""
    made = _log()
    up_and_down = np.minimum(made.target_deg, made.target_deg[::-1])
    (said,) = _faults(replace(made, target_deg=up_and_down))
    assert "target_deg moves against the column direction, as in 599 of 1199 steps" in said


def test_noisy_targets_and_the_opposite_sign_of_motion_are_no_faults() -> None:
    """The steps of noisy targets go back in 40 % of the rows, but the pass goes up."""
    made = _log()
    noisy = made.target_deg + np.random.default_rng(2).normal(0.0, 0.02, ROWS)
    assert np.mean(np.diff(noisy) < 0.0) > 0.35
    assert _faults(replace(made, target_deg=noisy)) == []
    assert _faults(replace(made, target_deg=-made.target_deg)) == []


@pytest.mark.parametrize("order", ["random", "down"])
def test_stations_that_are_approached_from_below_are_no_fault(order: str) -> None:
    """The column is the direction of approach, and the stations may follow each other in any
    order."""
    random = np.random.default_rng(7)
    stations = np.arange(0.0, 360.0, 5.0)
    target = random.permutation(stations) if order == "random" else stations[::-1]
    target = np.concatenate([stations, target])
    made = Reference(
        target,
        10.0 * np.cos(np.radians(target)) + random.normal(0.0, 0.3, target.size),
        time_s=np.arange(target.size) * 5.0,
        direction=np.ones(target.size, dtype=np.int64),
    )
    assert _faults(made) == []


@pytest.mark.parametrize("rows", [24, 400])
def test_a_sensor_that_stands_while_the_table_moves_is_bad_data(rows: int) -> None:
    made = _log(display=0.1)
    made.error_arcsec[400 : 400 + rows] = made.error_arcsec[400]
    found = diagnosis_of(MeasurementSet(Table(), None, made))
    assert found.verdict == "bad_data"
    (said,) = _faults(made)
    place = f"reference, rows 400 to {399 + rows} of the data, from line 402 of the file"
    assert said.startswith(place)
    assert f"one value in {rows} successive rows" in said


@pytest.mark.parametrize("display", [0.5, 2.0, 5.0, 20.0, 40.0])
@pytest.mark.parametrize("noise", [0.0, 0.5, 3.0])
@pytest.mark.parametrize("amplitude", [9.0, 21.0, 100.0])
def test_rounded_displays_are_no_faults(amplitude: float, noise: float, display: float) -> None:
    """A coarse display repeats its value for many rows, above all at the extrema of the error."""
    assert _faults(_log(noise=noise, amplitude=amplitude, display=display)) == []


def test_a_table_that_stands_may_have_equal_errors() -> None:
    made = _log()
    made.error_arcsec[400:800] = made.error_arcsec[400]
    made.target_deg[400:800] = made.target_deg[400]
    assert _faults(made) == []


def test_readings_at_the_limits_of_the_instrument_are_bad_data() -> None:
    """An autocollimator of ±20″ shows an error of ±30″: 48 % of an even sine are above 2/3."""
    made = _log(amplitude=30.0, display=0.01)
    clipped = np.clip(made.error_arcsec, -20.0, 20.0)
    (said,) = _faults(replace(made, error_arcsec=clipped))
    assert "the instrument is at the limit of its range" in said
    at_limit = np.abs(clipped) == 20.0
    assert f"line {int(np.flatnonzero(at_limit)[0]) + 2} of the file" in said
    largest, smallest = np.sum(clipped == 20.0), np.sum(clipped == -20.0)
    assert f"its largest value in {largest} rows and its smallest value in {smallest} rows" in said


@pytest.mark.parametrize("display", [0.01, 0.1, 1.0])
def test_the_extremum_of_a_rounded_curve_is_no_limit(display: float) -> None:
    assert _faults(_log(noise=0.0, amplitude=30.0, display=display)) == []


def test_runs_that_are_set_to_zero_show_no_limit() -> None:
    """24 runs over 90°, each set to zero at its first station: the value 0 is the smallest and
    occurs in each run, at one station only."""
    random = np.random.default_rng(4)
    station = np.tile(np.arange(0.0, 91.0, 5.0), 24)
    run = np.repeat(np.arange(24), 19)
    error = 0.2 * station + random.normal(0.0, 0.02, station.size)
    error = np.round(error - error[station == 0.0][run], 5)
    assert np.sum(error == error.min()) == 24
    assert _faults(Reference(station, error, run=run)) == []


def test_a_log_that_stands_first_shows_no_limit() -> None:
    """The display shows one value for 200 rows at the angle 0, and larger values afterwards."""
    made = _log(amplitude=0.0)
    moved = np.maximum(np.arange(ROWS) - 200, 0)
    error = np.where(moved > 0, np.abs(made.error_arcsec) + 0.02 * moved, 0.0)
    log = replace(made, target_deg=made.target_deg[moved] - made.target_deg[0], error_arcsec=error)
    assert not any("limit of its range" in said for said in _faults(log))
