"""Tests that pandas, xarray, astropy, HDF5 and dictionaries give the same measurement set."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arctrue as at
from arctrue.measurement import MeasurementError, MeasurementSet
from arctrue.measurement.digest import set_digest

COUNTS = 1 << 24
TABLE = {"counts_per_rev": COUNTS, "head_separation_deg": 33.0}
ROUNDING_ARCSEC = 1e-6
"""Bound in arcseconds of the rounding of errors, which are written with six decimals."""


def error_arcsec(angle_deg: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    return 30.0 * np.cos(np.deg2rad(angle_deg)) + 1.5 * np.sin(np.deg2rad(3.0 * angle_deg))


def heads(rows: int = 720) -> dict[str, np.ndarray[Any, Any]]:
    """Return readings of two turns forward and two turns backward, in degrees from 0 to 360."""
    up = np.linspace(0.0, 720.0, rows, endpoint=False)
    angle = np.concatenate([up, up[::-1]])
    time_s = np.arange(angle.size) * 0.01
    return {
        "time_s": time_s,
        "head1": (angle + error_arcsec(angle) / 3600.0) % 360.0,
        "head2": (angle + 33.0 + error_arcsec(angle + 33.0) / 3600.0) % 360.0,
        "temperature_c": 20.0 + 0.1 * time_s,
        "load_nm": np.sin(time_s),
    }


def stations() -> dict[str, np.ndarray[Any, Any]]:
    angle = np.tile(np.arange(24) * 15.0, 2)
    return {
        "target_deg": angle,
        "error_arcsec": error_arcsec(angle),
        "direction": np.repeat([1, -1], 24),
        "temperature_c": np.full(48, 20.5),
        "time_s": np.arange(48.0),
    }


def same(one: MeasurementSet, other: MeasurementSet) -> None:
    """Assert that two sets have the same columns, within the decimals of a written set."""
    assert one.table == other.table
    for channel in ("capture", "reference"):
        mine, theirs = getattr(one, channel), getattr(other, channel)
        assert (mine is None) == (theirs is None)
        if mine is None:
            continue
        for name, values in vars(mine).items():
            if isinstance(values, np.ndarray):
                np.testing.assert_allclose(values, getattr(theirs, name), atol=ROUNDING_ARCSEC)
        assert mine.conditions.keys() == theirs.conditions.keys()
        for name, values in mine.conditions.items():
            np.testing.assert_allclose(values, theirs.conditions[name])


def from_arrays() -> at.Dataset:
    return at.Dataset.from_arrays(
        heads(), stations(), units={"head1": "deg", "head2": "deg"}, **TABLE
    )


def from_pandas() -> at.Dataset:
    pandas = pytest.importorskip("pandas")
    return at.Dataset.from_pandas(
        pandas.DataFrame(heads()),
        pandas.DataFrame(stations(), index=np.arange(100, 148)),
        units={"head1": "deg", "head2": "deg"},
        **TABLE,
    )


def from_xarray() -> at.Dataset:
    xarray = pytest.importorskip("xarray")
    columns, units = heads(), {"head1": "deg", "head2": "deg"}
    capture = xarray.Dataset(
        {
            name: ("time_s", values, {"units": units.get(name, "")})
            for name, values in columns.items()
            if name != "time_s"
        },
        coords={"time_s": ("time_s", columns["time_s"])},
        attrs=TABLE,
    )
    reference = xarray.Dataset({name: ("row", values) for name, values in stations().items()})
    return at.Dataset.from_xarray(capture, reference)


def from_astropy() -> at.Dataset:
    units = pytest.importorskip("astropy.units")
    capture: dict[str, Any] = heads()
    capture["head1"] = (capture["head1"] * units.deg).to(units.rad)
    capture["head2"] = (capture["head2"] * units.deg).to(units.hourangle)
    capture["time"] = (capture.pop("time_s") * units.s).to(units.ms)
    capture["temperature"] = (capture.pop("temperature_c") + 273.15) * units.K
    capture["load_nm"] = capture.pop("load_nm")
    reference: dict[str, Any] = stations()
    reference["error"] = (reference.pop("error_arcsec") * units.arcsec).to(units.urad)
    reference["temperature"] = reference.pop("temperature_c") * units.deg_C
    return at.Dataset.from_arrays(capture, reference, **TABLE)


def from_hdf5(folder: Path) -> at.Dataset:
    h5py = pytest.importorskip("h5py")
    with h5py.File(folder / "log.h5", "w") as file:
        file.attrs.update(TABLE)
        for place, columns in (("entry/heads", heads()), ("entry/polygon", stations())):
            for name, values in columns.items():
                file[f"{place}/{name}"] = values
        for name in ("head1", "head2"):
            file[f"entry/heads/{name}"].attrs["units"] = "degree"
        file["entry/heads/picture"] = np.zeros((2, 2))
    return at.Dataset.from_hdf5(folder / "log.h5", "/entry/heads", "entry/polygon")


@pytest.mark.parametrize("made", [from_pandas, from_xarray, from_astropy])
def test_each_library_gives_the_same_set(made: Callable[[], at.Dataset]) -> None:
    same(made(), from_arrays())


def test_an_hdf5_file_gives_the_same_set(tmp_path: Path) -> None:
    same(from_hdf5(tmp_path), from_arrays())


def test_the_columns_are_those_of_the_equations() -> None:
    """The test computes the counts of the unwrapped reading from the equation. The columns equal
    these counts in the upward run, and differ from them by whole turns in the downward run."""
    data = from_arrays()
    up = np.linspace(0.0, 720.0, 720, endpoint=False)
    angle = np.concatenate([up, up[::-1]])
    expected = np.round((angle + error_arcsec(angle) / 3600.0) / 360.0 * COUNTS)
    assert data.capture is not None
    # The first reading, 30″, belongs to turn 0, because no earlier reading precedes it.
    np.testing.assert_array_equal(data.capture.head1_counts[:720], expected[:720])
    down = data.capture.head1_counts[720:] - expected[720:]
    assert np.unique(down).size == 1
    assert down[0] % COUNTS == 0
    np.testing.assert_array_equal(np.unique(data.capture.run), [0, 1])
    assert np.flatnonzero(np.diff(data.capture.run)).tolist() in ([719], [720])
    assert data.reference is not None
    np.testing.assert_array_equal(data.reference.direction, stations()["direction"])


def test_a_set_that_is_written_is_read_again(tmp_path: Path) -> None:
    data = from_arrays()
    at.write_set(tmp_path / "set", data)
    again = at.read_set(tmp_path / "set")
    same(again, data)
    # A command writes the same hash into the history of a model.
    assert data.sha256 == again.sha256 == set_digest(tmp_path / "set")
    at.write_set(tmp_path / "copy", again)
    assert set_digest(tmp_path / "copy") == again.sha256
    assert at.compare(tmp_path / "set").data["channels"]["reference"]["rows"] == 48


def test_a_changed_set_has_another_hash(tmp_path: Path) -> None:
    at.write_set(tmp_path / "set", from_arrays())
    read = at.read_set(tmp_path / "set")
    assert read.reference is not None
    half = replace(read, reference=read.reference.where(np.arange(48) < 24))
    assert half.folder == read.folder
    assert half.sha256 != read.sha256
    at.write_set(tmp_path / "half", half)
    assert half.sha256 == set_digest(tmp_path / "half")


def test_dates_become_seconds_of_one_clock() -> None:
    capture: dict[str, Any] = heads()
    reference: dict[str, Any] = stations()
    begin = np.datetime64("2026-11-23T08:00:00", "ns")
    capture["time"] = begin + (capture.pop("time_s") * 1e9).astype("timedelta64[ns]")
    reference["time"] = begin + np.timedelta64(60, "s") + np.arange(48) * np.timedelta64(1, "s")
    del reference["time_s"]
    data = at.Dataset.from_arrays(
        capture, reference, units={"head1": "deg", "head2": "deg"}, **TABLE
    )
    assert data.capture is not None
    assert data.reference is not None
    np.testing.assert_allclose(data.capture.time_s, heads()["time_s"], atol=1e-9)
    assert data.reference.time_s is not None
    np.testing.assert_allclose(data.reference.time_s, 60.0 + np.arange(48))


@pytest.mark.parametrize("of_pandas", [False, True])
@pytest.mark.parametrize("kind", ["datetime64[ns]", "timedelta64[ns]", "object"])
def test_a_date_that_is_missing_is_refused_with_its_row(kind: str, of_pandas: bool) -> None:
    pandas = pytest.importorskip("pandas")
    reference: dict[str, Any] = stations()
    seconds = np.arange(48).astype("timedelta64[s]").astype("timedelta64[ns]")
    times = seconds if kind.startswith("timedelta") else np.datetime64("2026-11-23", "ns") + seconds
    times[47] = np.timedelta64("NaT") if kind.startswith("timedelta") else np.datetime64("NaT")
    column = pandas.Series(times)
    if kind == "object":
        column = column.dt.tz_localize("UTC")
    reference["time"] = column if of_pandas else column.to_numpy()
    del reference["time_s"]
    with pytest.raises(MeasurementError, match=r"column time: row 47: expected a time, found NaT"):
        at.Dataset.from_arrays(reference=reference)


def test_a_name_of_ones_own_is_said() -> None:
    own = {"Winkel": stations()["target_deg"], "delta": stations()["error_arcsec"] / 3600.0}
    data = at.Dataset.from_arrays(
        reference=own,
        columns={"target": "Winkel", "error_arcsec": "delta"},
        units={"Winkel": "deg", "error": "degrees"},
        faces=24,
        instrument="polygon",
    )
    assert data.reference is not None
    np.testing.assert_allclose(data.reference.error_arcsec, stations()["error_arcsec"])
    assert (data.reference.faces, data.reference.instrument) == (24, "polygon")


def changed(**columns: Any) -> dict[str, Any]:
    found = {**stations(), **columns}
    return {name: values for name, values in found.items() if values is not None}


@pytest.mark.parametrize(
    ("reference", "options", "said"),
    [
        (changed(error_arcsec=None), {}, r"reference, column error_arcsec: is missing.*columns="),
        (
            changed(error_arcsec=None, error=np.zeros(48)),
            {},
            r"column error: its unit is not known; expected one of deg, rad.*units=",
        ),
        (
            changed(),
            {"units": {"error": "volt"}},
            r"column error_arcsec: expected a unit of angle .*found 'volt'",
        ),
        (
            changed(error_arcsec=["1", "x", *["2"] * 46]),
            {},
            r"column error_arcsec: row 1: expected a number, found .*'x'",
        ),
        (
            changed(error_arcsec=np.where(np.arange(48) == 7, np.nan, 1.0)),
            {},
            r"row 7: expected a finite number, found nan; leave such rows out.*dropna",
        ),
        (changed(direction=np.full(48, 2)), {}, r"row 0: expected \+1 .* or -1, found 2"),
        (changed(cycle=np.full(48, 0.5)), {}, r"column cycle: row 0: expected a whole number"),
        (changed(time_s=np.arange(48)[::-1]), {}, r"row 1: time runs backwards, from 47 to 46 s"),
        (changed(), {"columns": {"error": "eror_arcsec"}}, r"does not exist. Did you mean error"),
        (changed(), {"faces": 0}, r"keywords: reference.faces: expected a whole number from 1"),
    ],
)
def test_what_is_wrong_is_said(
    reference: dict[str, Any], options: dict[str, Any], said: str
) -> None:
    with pytest.raises(MeasurementError, match=said):
        at.Dataset.from_arrays(reference=reference, **options)


def test_a_capture_says_what_its_table_lacks() -> None:
    units = {"head1": "deg", "head2": "deg"}
    with pytest.raises(MeasurementError, match=r"in deg and the set needs counts.*counts_per_rev="):
        at.Dataset.from_arrays(heads(), units=units)
    with pytest.raises(MeasurementError, match=r"table.head_separation_deg: is missing"):
        at.Dataset.from_arrays(heads(), units=units, counts_per_rev=COUNTS)
    with pytest.raises(TypeError, match=r"head_seperation_deg is not known. Did you mean head_sep"):
        at.Dataset.from_arrays(heads(), units=units, head_seperation_deg=33.0)  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="expected a capture, a reference or both"):
        at.Dataset.from_arrays()
    with pytest.raises(TypeError, match=r"hed1 is neither a quantity nor a column. Did you mean"):
        at.Dataset.from_arrays(heads(), units={"hed1": "deg"}, **TABLE)


def test_an_hdf5_file_without_the_group_says_which_are_there(tmp_path: Path) -> None:
    from_hdf5(tmp_path)
    with pytest.raises(MeasurementError, match=r"no group /nothing; there are /entry/heads"):
        at.Dataset.from_hdf5(tmp_path / "log.h5", "/nothing")
    with pytest.raises(MeasurementError, match=r"neither /capture nor /reference.*/entry/heads"):
        at.Dataset.from_hdf5(tmp_path / "log.h5")
    with pytest.raises(MeasurementError, match="no such file"):
        at.Dataset.from_hdf5(tmp_path / "none.h5", "/a")


def test_text_next_to_the_numbers_is_left_out_with_a_warning() -> None:
    data = at.Dataset.from_arrays(reference=changed(remark=["a"] * 48, room=np.arange(48)))
    assert data.reference is not None
    assert list(data.reference.conditions) == ["room"]
    assert data.warnings == (
        "reference: column remark is not used: not all of its values are finite numbers",
    )


def test_an_uncertainty_of_zero_is_reported() -> None:
    columns = {"target_deg": [0.0, 15.0, 30.0], "error_arcsec": [1.0, 2.0, 0.5]}
    read = at.Dataset.from_arrays(reference={**columns, "u_arcsec": [0.2, 0.0, 0.2]})
    (said,) = read.warnings
    assert said.startswith("reference, row 1, column u_arcsec: expected more than 0, found 0")
    assert at.Dataset.from_arrays(reference={**columns, "u_arcsec": [0.2] * 3}).warnings == ()


def test_a_history_has_date_version_and_hash(tmp_path: Path) -> None:
    """The history has the date, version and hash that a command writes for this folder."""
    at.write_set(tmp_path / "set", from_arrays())
    model = at.add("hysteresis", tmp_path / "set")
    assert {step.measurement_sha256 for step in model.history} == {set_digest(tmp_path / "set")}
    assert {step.program for step in model.history} == {f"arctrue {version('arctrue')}"}
    assert {step.measurement for step in model.history} == {"set"}
    assert all(step.date.startswith("20") for step in model.history)
    smaller = at.drop("hysteresis", from_arrays(), model)
    assert smaller.effects == ["graduation_harmonics"]
    # The same rows in memory give the same hash.
    assert smaller.history[-1].measurement_sha256 == set_digest(tmp_path / "set")
    assert [step.action for step in smaller.history] == ["fit", "add", "drop"]
