"""Tests that masked and impossible values are refused, that packed values are unpacked, and that
times keep their zone."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta, timezone
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arctrue as at
from arctrue.measurement import MeasurementError

ROWS = 48
ANGLE = np.tile(np.arange(24) * 15.0, 2)
ERROR = 2.0 * np.cos(np.deg2rad(ANGLE))
COUNTS = 1 << 24


def reference(**columns: Any) -> at.Dataset:
    rows = {"target_deg": ANGLE, "error_arcsec": ERROR, **columns}
    return at.Dataset.from_arrays(reference=rows, counts_per_rev=COUNTS)


def test_a_masked_value_is_refused_with_its_row() -> None:
    masked = np.ma.array(ERROR, mask=np.arange(ROWS) == 5)
    masked.data[5] = 999.0
    with pytest.raises(MeasurementError, match=r"error_arcsec.*row 5: the value is masked"):
        reference(error_arcsec=masked)
    assert reference(error_arcsec=np.ma.array(ERROR)).reference is not None
    unused = reference(load=masked)
    assert any("load is not used" in text for text in unused.warnings)
    assert unused.reference is not None
    assert not unused.reference.conditions


def hdf5(path: Path, values: Any, **attributes: Any) -> at.Dataset:
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        group = file.create_group("reference")
        group["target_deg"] = ANGLE
        group["error_arcsec"] = values
        group["error_arcsec"].attrs.update(attributes)
    return at.Dataset.from_hdf5(path)


def test_packed_values_are_unpacked(tmp_path: Path) -> None:
    """A packed value p stands for p·scale_factor + add_offset (CF conventions)."""
    packed = np.round((ERROR - 0.25) / 1e-3).astype(np.int32)
    found = hdf5(tmp_path / "a.h5", packed, scale_factor=1e-3, add_offset=0.25)
    assert found.reference is not None
    np.testing.assert_allclose(found.reference.error_arcsec, ERROR, atol=0.51e-3)
    xarray = pytest.importorskip("xarray")
    table = xarray.Dataset(
        {
            "target_deg": ("row", ANGLE),
            "error_arcsec": ("row", packed, {"scale_factor": 1e-3, "add_offset": 0.25}),
        }
    )
    again = at.Dataset.from_xarray(reference=table).reference
    assert again is not None
    np.testing.assert_array_equal(again.error_arcsec, found.reference.error_arcsec)


@pytest.mark.parametrize("name", ["_FillValue", "missing_value"])
def test_a_filled_value_is_refused_with_its_row(tmp_path: Path, name: str) -> None:
    filled = np.where(np.arange(ROWS) == 7, -9999.0, ERROR)
    with pytest.raises(MeasurementError, match="row 7: expected a finite number, found nan"):
        hdf5(tmp_path / "a.h5", filled, **{name: -9999.0})


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        ({"error_arcsec": ERROR + 1j}, "expected a real number"),
        ({"head1_counts": np.full(ROWS, 2**63 + 5, dtype=np.uint64)}, "row 0: expected a number b"),
    ],
)
def test_numbers_that_do_not_fit_are_refused(columns: dict[str, Any], said: str) -> None:
    with pytest.raises(MeasurementError, match=said):
        reference(**columns)


def test_a_column_is_one_quantity() -> None:
    with pytest.raises(MeasurementError, match="a_deg: is given for target and for error"):
        at.Dataset.from_arrays(
            reference={"a_deg": ANGLE, "error_arcsec": ERROR},
            columns={"target": "a_deg", "error": "a_deg"},
        )


def moments(zone: Any) -> list[datetime]:
    start = datetime(2026, 3, 29, 0, 30, tzinfo=zone)
    return [start + timedelta(seconds=100 * place, microseconds=1) for place in range(ROWS)]


def test_dates_without_a_zone_are_utc(monkeypatch: pytest.MonkeyPatch) -> None:
    """The clock of Berlin changes within these dates; UTC does not."""
    import time

    monkeypatch.setenv("TZ", "Europe/Berlin")
    time.tzset()
    try:
        found = reference(time=np.array(moments(None), dtype=object)).reference
    finally:
        monkeypatch.undo()
        time.tzset()
    assert found is not None
    assert found.time_s is not None
    np.testing.assert_allclose(found.time_s, 100.0 * np.arange(ROWS), atol=1e-9)


def test_dates_with_a_zone_keep_their_microseconds() -> None:
    dates = np.array(
        [datetime(2026, 6, 1, tzinfo=UTC) + timedelta(microseconds=int(n)) for n in range(ROWS)],
        dtype=object,
    )
    found = reference(time=dates).reference
    assert found is not None
    assert found.time_s is not None
    np.testing.assert_allclose(found.time_s, 1e-6 * np.arange(ROWS), atol=1e-12)


def test_timestamps_keep_their_nanoseconds() -> None:
    pandas = pytest.importorskip("pandas")
    index = pandas.date_range("2026-06-01", periods=ROWS, freq="7ns", tz="Europe/Berlin")
    table = pandas.DataFrame({"target_deg": ANGLE, "error_arcsec": ERROR, "time": index})
    found = at.Dataset.from_pandas(reference=table).reference
    assert found is not None
    assert found.time_s is not None
    np.testing.assert_allclose(found.time_s, 7e-9 * np.arange(ROWS), atol=1e-13)


def test_dates_with_and_without_a_zone_are_not_mixed() -> None:
    rows = {
        "head1_counts": np.arange(ROWS) * 1000,
        "head2_counts": np.arange(ROWS) * 1000,
    }
    naive, aware = (np.array(moments(zone), dtype=object) for zone in (None, UTC))
    with pytest.raises(MeasurementError, match="capture has dates without a time zone, reference"):
        at.Dataset.from_arrays(
            capture={"time": naive, **rows},
            reference={"time": aware, "target_deg": ANGLE, "error_arcsec": ERROR},
            counts_per_rev=COUNTS,
            head_separation_deg=33.0,
        )
    mixed = naive.copy()
    mixed[3] = moments(timezone(timedelta(hours=2)))[3]
    with pytest.raises(MeasurementError, match="row 3: expected dates that all have a time zone"):
        reference(time=mixed)


def test_a_table_without_rows_is_refused() -> None:
    with pytest.raises(MeasurementError, match="reference: has no rows"):
        reference(target_deg=[], error_arcsec=[])
