"""Tests that sets are read and written with the same numbers, texts and errors if pyarrow is not
installed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import arctrue as at
from arctrue.measurement import MeasurementError, csv_blocks, writer
from arctrue.measurement.writer import number_text

DATA = Path(__file__).resolve().parents[3] / "docs" / "data"


@pytest.fixture
def no_pyarrow(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (csv_blocks, writer):
        monkeypatch.setattr(module, "installed", lambda _: False)


def written(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_a_set_is_the_same(tmp_path: Path, request: pytest.FixtureRequest) -> None:
    sets = {
        "simulated": at.simulate("hysteresis", experiment="lean", seed=2),
        **{path.name: at.read_set(path) for path in DATA.iterdir() if path.is_dir()},
    }
    for name, data in sets.items():
        at.write_set(tmp_path / f"{name} with", data)
    request.getfixturevalue("no_pyarrow")
    for name, data in sets.items():
        at.write_set(tmp_path / f"{name} without", data)
        assert written(tmp_path / f"{name} without") == written(tmp_path / f"{name} with"), name
        again = at.read_set(tmp_path / f"{name} with")
        for channel in (again.capture, again.reference):
            expected = getattr(data, "capture" if channel is again.capture else "reference")
            assert (channel is None) == (expected is None)
            for column, values in vars(channel).items() if channel is not None else ():
                if isinstance(values, np.ndarray) and column != "trusted":
                    np.testing.assert_allclose(values, getattr(expected, column), atol=1e-3)


@settings(max_examples=300, deadline=None)
@given(st.floats(-1e12, 1e12, allow_nan=False))
def test_a_number_has_the_text_that_pyarrow_gives_it(value: float) -> None:
    import io

    import pyarrow as pa  # type: ignore[import-untyped]
    import pyarrow.csv as pa_csv  # type: ignore[import-untyped]

    for number in (value, round(value, 6), round(value / 1e9, 9), round(value / 1e14, 9)):
        buffer = io.BytesIO()
        pa_csv.write_csv(
            pa.table({"a": [number]}), buffer, pa_csv.WriteOptions(include_header=False)
        )
        assert number_text(number) == buffer.getvalue().decode().strip()
        assert float(number_text(number)) == number


BAD = {
    "text": "target_deg,error_arcsec\n0,1\n15,abc\n",
    "empty field": "target_deg,error_arcsec\n0,1\n15,\n",
    "too many": "target_deg,error_arcsec\n0,1\n15,2,3\n",
    "nothing": "target_deg,error_arcsec\n",
    "large": "target_deg,error_arcsec\n0,1e15\n",
    "fraction": "target_deg,error_arcsec,cycle\n0,1,0.5\n",
    "hexadecimal": "target_deg,error_arcsec\n0,0x10\n",
    "time": "target_deg,error_arcsec,time_s\n0,1,5\n1,1,4\n",
}


@pytest.mark.parametrize("kind", BAD)
def test_a_bad_file_is_said_in_the_same_words(
    kind: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    (tmp_path / "measurement.toml").write_text("schema = 1\n", encoding="utf-8")
    (tmp_path / "reference.csv").write_text(BAD[kind], encoding="utf-8")
    with pytest.raises(MeasurementError) as expected:
        at.read_set(tmp_path)
    request.getfixturevalue("no_pyarrow")
    with pytest.raises(MeasurementError) as found:
        at.read_set(tmp_path)
    assert str(found.value) == str(expected.value)


def test_conditions_and_a_cut_line_are_the_same(
    tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    (tmp_path / "measurement.toml").write_text("schema = 1\n", encoding="utf-8")
    text = "target_deg,error_arcsec,load,remark\n" + "0, 1.5,2e0,a\n" * 5 + "15,2"
    (tmp_path / "reference.csv").write_text(text, encoding="utf-8")
    expected = at.read_set(tmp_path)
    request.getfixturevalue("no_pyarrow")
    found = at.read_set(tmp_path)
    assert found.warnings == expected.warnings
    assert found.reference is not None
    assert expected.reference is not None
    assert list(found.reference.conditions) == list(expected.reference.conditions) == ["load"]
    np.testing.assert_array_equal(found.reference.error_arcsec, expected.reference.error_arcsec)
