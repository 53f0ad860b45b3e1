"""Tests of the table's true angle in the rows of a reference."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of

from arctrue.measurement import MeasurementSet, Reference, Table, read_measurement_set
from arctrue.workbench.observations.build import observations_of

COUNTS = 1 << 22
ROWS = 900
NOISE = 0.6
"""Noise of the error column, arcseconds."""
ARCSEC = np.pi / 648_000.0


def _arc(*, follows: bool, sign: float = 1.0, order: float = 1024.0) -> MeasurementSet:
    """Return a log over 8° with an error of 0.5″ per degree, a line of 3″ and noise.

    ``follows``: head 1 has the commanded angle, as with a drive that brings the reading to the
    target; otherwise the reading is the reference plus the error. ``sign``: sign of the column.
    """
    random = np.random.default_rng(11)
    target = np.linspace(0.0, 8.0, ROWS)
    error = 0.5 * target + 3.0 * np.cos(order * np.radians(target))
    error += random.normal(0.0, NOISE, ROWS)
    reading = target + (0.0 if follows else error / 3600.0)
    table = Table(counts_per_rev=COUNTS, grating_lines=1024)
    columns = Reference(
        target,
        sign * error,
        time_s=target / 2.0,
        head1_counts=np.round(reading / 360.0 * COUNTS).astype(np.int64),
    )
    return MeasurementSet(table, None, columns, title="arc")


@pytest.mark.parametrize("follows", [True, False])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_angle_of_an_arc_does_not_contain_the_noise_of_the_error(
    follows: bool, sign: float
) -> None:
    """Only rounding remains of the angle minus a polynomial in the time: rounding to a count of
    0.31″ is 0.09″ RMS. If the angle contained the measured error, line and noise would be 2.2″
    RMS."""
    rows = observations_of(_arc(follows=follows, sign=sign)).reference
    assert rows is not None
    assert rows.time_s is not None
    time = rows.time_s - rows.time_s.mean()
    left = rows.angle_rad - np.polyval(np.polyfit(time, rows.angle_rad, 6), time)
    assert float(np.std(left)) < 0.12 * ARCSEC


def test_a_line_over_an_arc_is_not_taken_for_a_drift() -> None:
    """The signal period of 1,024 lines is named, although head 1 holds the commanded angle."""
    found = diagnosis_of(_arc(follows=True))
    assert found.named is not None
    assert found.named.name in ("subdivision_error", "periodic_error")


def test_errors_of_the_opposite_sign_give_a_warning(tmp_path: Path) -> None:
    for sign, follows, warned in ((-1.0, False, 1), (1.0, False, 0), (-1.0, True, 0)):
        made = _arc(follows=follows, sign=sign)
        assert made.reference is not None
        assert made.reference.head1_counts is not None
        np.savetxt(
            tmp_path / "reference.csv",
            np.column_stack(
                [
                    made.reference.target_deg,
                    made.reference.head1_counts,
                    made.reference.error_arcsec,
                ]
            ),
            fmt=["%.6f", "%d", "%.4f"],
            delimiter=",",
            header="target_deg,head1_counts,error_arcsec",
            comments="",
        )
        (tmp_path / "measurement.toml").write_text(
            f'schema = 1\ntitle = "arc"\n[table]\ncounts_per_rev = {COUNTS}\n'
            '[reference]\nfile = "reference.csv"\ninstrument = "encoder"\n'
        )
        found = [
            text for text in read_measurement_set(tmp_path).warnings if "opposite sign" in text
        ]
        assert len(found) == warned
        assert all("reference.csv, column error_arcsec" in text for text in found)


def test_errors_of_the_opposite_sign_have_the_target_as_the_angle() -> None:
    made = _arc(follows=False, sign=-1.0)
    rows = observations_of(made).reference
    assert rows is not None
    np.testing.assert_array_equal(rows.angle_rad, rows.target_rad)


def test_a_whole_turn_keeps_the_angle_that_the_errors_give() -> None:
    """Over a whole turn, θ is the reading minus the measured error, because no order of the angle
    looks like a drift."""
    made = _arc(follows=True)
    assert made.reference is not None
    target = np.linspace(0.0, 360.0, ROWS, endpoint=False)
    counts = np.round(target / 360.0 * COUNTS).astype(np.int64)
    made = replace(made, reference=replace(made.reference, target_deg=target, head1_counts=counts))
    rows = observations_of(made).reference
    assert rows is not None
    reading = counts * (2.0 * np.pi / COUNTS)
    np.testing.assert_allclose(rows.angle_rad, reading - rows.error_arcsec * ARCSEC, atol=1e-12)
