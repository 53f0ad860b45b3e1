"""Tests that rows which a file contains twice count once, and that columns in a wrong unit give a
warning."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table, write_measurement_set
from arctrue.workbench.noise.doubtful_units import doubtful_units
from arctrue.workbench.observations.build import observations_of
from tests.command_line import arctrue

ROWS = 144


def _reference(unit: float = 1.0, u_arcsec: float | None = 0.5) -> Reference:
    """Return six visits of 24 stations with 0.4″ of noise; ``unit``: unit of the errors,
    arcseconds."""
    random = np.random.default_rng(2)
    target = np.tile(np.arange(24) * 15.0, ROWS // 24)
    error = 8.0 * np.cos(np.radians(target) - 0.3) + random.normal(0.0, 0.4, ROWS)
    return Reference(
        target_deg=target,
        error_arcsec=error / unit,
        run=np.zeros(ROWS, dtype=np.int64),
        time_s=np.arange(ROWS) * 7.0,
        cycle=np.arange(ROWS) // 24,
        standard_uncertainty_arcsec=u_arcsec,
    )


def _twice(reference: Reference) -> Reference:
    """Return the reference with every row twice, as after joining a file with itself."""
    columns = ("target_deg", "error_arcsec", "run", "time_s", "cycle")
    return replace(reference, **{name: np.repeat(getattr(reference, name), 2) for name in columns})


def test_a_row_that_is_there_twice_counts_once() -> None:
    once = observations_of(MeasurementSet(Table(), None, _reference()))
    twice = observations_of(MeasurementSet(Table(), None, _twice(_reference())))
    assert twice.reference is not None
    assert once.reference is not None
    np.testing.assert_array_equal(twice.reference.error_arcsec, once.reference.error_arcsec)
    assert [row.reason for row in twice.masked] == ["duplicate"] * ROWS
    # The header is line 1, so that the second row of a pair is line 3, 5, …
    assert [row.row for row in twice.masked[:2]] == [3, 5]
    assert twice.reference_line(1) == 4


def test_equal_readings_at_different_times_are_readings() -> None:
    reference = _reference()
    rounded = replace(reference, error_arcsec=np.round(reference.error_arcsec))
    assert observations_of(MeasurementSet(Table(), None, rounded)).masked == ()
    untimed = replace(_twice(rounded), time_s=None)
    assert observations_of(MeasurementSet(Table(), None, untimed)).masked == ()


@pytest.mark.parametrize("unit", [60.0, 3600.0, 206_264.8])
def test_errors_in_another_unit(unit: float) -> None:
    """0.4″ of scatter is 0.0067 arcminutes, less than a sixtieth of the stated 0.5″."""
    made = MeasurementSet(Table(), None, _reference(unit))
    (said,) = doubtful_units(observations_of(made))
    assert "is error_arcsec in arcseconds" in said


def test_a_reference_that_repeats_better_than_its_uncertainty() -> None:
    """No warning where the repeats are ten times better than the stated uncertainty, which also
    contains constant parts, or where no uncertainty is stated."""
    for reference in (_reference(), _reference(u_arcsec=4.0), _reference(3600.0, None)):
        made = MeasurementSet(Table(), None, reference)
        assert doubtful_units(observations_of(made)) == []


def test_compare_says_so(tmp_path: Path) -> None:
    target = np.radians(_reference().target_deg)
    made = replace(_twice(_reference(3600.0)), target_deg=np.repeat(target, 2))
    write_measurement_set(tmp_path / "set", MeasurementSet(Table(), None, made))
    said = " ".join(arctrue("compare", tmp_path / "set").output.split())
    assert "144 rows that equal an earlier row in every column" in said
    assert "one turn is 6.28 radians" in said
