"""Tests how the date of a measurement set is read, written, refused and joined."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path

import pytest
from click.testing import CliRunner

import arctrue as at
from arctrue.cli import main
from arctrue.measurement import (
    MeasurementError,
    MeasurementSet,
    Reference,
    Table,
    joined,
    read_measurement_set,
    write_measurement_set,
)

NOON = datetime(2026, 3, 12, 12, 0, tzinfo=timezone(timedelta(hours=1)))


def folder_with(place: Path, line: str) -> Path:
    (place / "measurement.toml").write_text(f"schema = 1\n{line}\n")
    (place / "reference.csv").write_text("target_deg,error_arcsec\n0,1\n15,2\n")
    return place


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("", None),
        ("date = 2026-03-12", datetime(2026, 3, 12, tzinfo=UTC)),
        ("date = 2026-03-12T12:00:00+01:00", NOON),
        ('date = "2026-03-12T12:00:00+01:00"', NOON),
        ('date = "2026-03-12T09:30"', datetime(2026, 3, 12, 9, 30, tzinfo=UTC)),
    ],
)
def test_a_date_is_read(tmp_path: Path, line: str, expected: datetime | None) -> None:
    found = read_measurement_set(folder_with(tmp_path, line))
    assert found.date == expected
    assert found.warnings == ()


def test_what_is_no_date_is_refused_with_its_file(tmp_path: Path) -> None:
    with pytest.raises(MeasurementError, match=r"measurement.toml: date: expected a date such as"):
        read_measurement_set(folder_with(tmp_path, 'date = "last Monday"'))


def reference_set(date: datetime | None, error: float = 1.0) -> MeasurementSet:
    rows = Reference(target_deg=[0.0, 15.0], error_arcsec=[error, 2.0])  # type: ignore[arg-type]
    return MeasurementSet(Table(), reference=rows, date=date)


def test_a_date_is_written_and_read_again(tmp_path: Path) -> None:
    write_measurement_set(tmp_path, reference_set(NOON))
    assert read_measurement_set(tmp_path).date == NOON


def test_joined_sets_have_the_first_date() -> None:
    later = NOON + timedelta(days=1)
    made, _ = joined([reference_set(later), reference_set(NOON, 3.0), reference_set(None, 4.0)])
    assert made.date == NOON


def test_the_python_interface_takes_a_date(tmp_path: Path) -> None:
    columns = {"target_deg": [0.0, 15.0], "error_arcsec": [1.0, 2.0]}
    data = at.Dataset.from_arrays(reference=columns, date="2026-03-12T12:00:00+01:00")
    assert data.date == NOON
    assert at.Dataset.from_arrays(reference=columns, date=NOON).date == NOON  # type: ignore[arg-type]
    assert at.Dataset.of(data).sha256 != replace(data, date=None).sha256


def test_import_takes_a_date(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("target_deg,error_arcsec\n0,1\n15,2\n30,1\n")
    words = ["import", str(tmp_path / "a.csv"), "--sign", "reading-true"]
    refused = CliRunner().invoke(main, [*words, "--date", "yesterday", str(tmp_path / "no")])
    assert refused.exit_code == 2
    assert "--date: expected a date such as 2026-03-12" in refused.output
    done = CliRunner().invoke(main, [*words, "--date", "2026-03-12", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    assert read_measurement_set(tmp_path / "out").date == datetime(2026, 3, 12, tzinfo=UTC)
