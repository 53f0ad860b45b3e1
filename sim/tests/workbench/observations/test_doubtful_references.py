"""Tests that rows which a file contains twice count once, and that columns in a wrong unit give a
warning."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table, write_measurement_set
from arctrue.workbench.noise.doubtful_columns import doubtful_units, opposite_signs
from arctrue.workbench.observations import Observations
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
    """If the errors are in arcminutes, a scatter of 0.4″ is 0.0067, less than a sixtieth of the
    stated 0.5″."""
    made = MeasurementSet(Table(), None, _reference(unit))
    (said,) = doubtful_units(observations_of(made))
    assert "is error_arcsec in arcseconds" in said


def test_a_reference_that_repeats_better_than_its_uncertainty() -> None:
    """The workbench gives no warning if the repeats are ten times better than the stated
    uncertainty, which also contains constant parts, or if no uncertainty is stated."""
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


def _in_both_directions(sign_downwards: float) -> Observations:
    """Return four runs over 24 stations, up and down; the downward errors are multiplied."""
    random = np.random.default_rng(4)
    forth = np.arange(24) * 15.0
    target = np.tile(np.concatenate([forth, forth[::-1]]), 2)
    side = np.tile(np.repeat([1, -1], 24), 2)
    disc = 5.0 * np.cos(np.radians(target)) + 2.0 * np.sin(np.radians(3.0 * target))
    # A reversal error of 3″ is common; it must not count as a change of sign.
    error = disc * np.where(side > 0, 1.0, sign_downwards) + 1.5 * side
    reference = Reference(
        target_deg=target,
        error_arcsec=error + random.normal(0.0, 0.2, target.size),
        run=np.repeat(np.arange(4), 24),
        time_s=np.arange(target.size) * 5.0,
        direction=side,
    )
    return observations_of(MeasurementSet(Table(), None, reference))


def test_runs_downwards_with_the_wrong_sign_are_noticed() -> None:
    (warning,) = opposite_signs(_in_both_directions(-1.0))
    assert "the means upwards and downwards have a correlation of -0.99" in warning
    assert opposite_signs(_in_both_directions(1.0)) == []
    # A graduation that is half as large downwards has no wrong sign.
    assert opposite_signs(_in_both_directions(0.5)) == []


def test_noise_in_one_direction_has_no_wrong_sign() -> None:
    # The downward means contain only the noise of two runs at 24 places.
    assert opposite_signs(_in_both_directions(0.0)) == []
