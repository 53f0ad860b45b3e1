"""Tests that a description can name only files inside the set, and that readers refuse deep nesting
without a crash."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from arctrue.base.toml_file import DEEPEST, TomlContentError, parse_toml
from arctrue.cli._settings import settings_from
from arctrue.gateware.coefficient_file import CoefficientFileError, read_coefficient_file
from arctrue.measurement import MeasurementError, read_measurement_set
from arctrue.studies.scenario.reader import ScenarioError, read_scenario
from arctrue.workbench.model.model_file import ModelFileError, read_model

DESCRIPTION = """schema = 1
[table]
counts_per_rev = 16777216
head_separation_deg = 33.0
[{section}]
file = {name}
"""
ROWS = {
    "capture": "run,time_s,head1_counts,head2_counts\n0,0.0,1,2\n0,0.1,3,4\n",
    "reference": "target_deg,error_arcsec\n0,1\n15,2\n",
}


@pytest.mark.parametrize("section", ["capture", "reference"])
@pytest.mark.parametrize(
    "name",
    [
        "../x.csv",
        "a/../../x.csv",
        "{outside}",
        "..",
        "..\\\\x.csv",
        "C:\\\\x.csv",
        "\\\\\\\\host\\\\x",
    ],
)
def test_a_file_outside_the_set_is_refused(tmp_path: Path, section: str, name: str) -> None:
    outside = tmp_path / "x.csv"
    outside.write_text(ROWS[section])
    folder = tmp_path / "set"
    folder.mkdir()
    (folder / "measurement.toml").write_text(
        DESCRIPTION.format(section=section, name=f'"{name.format(outside=outside)}"')
    )
    with pytest.raises(MeasurementError, match=f"{section}.file: expected a file in the set's own"):
        read_measurement_set(folder)


@pytest.mark.parametrize("section", ["capture", "reference"])
def test_a_file_in_a_folder_of_the_set_is_read(tmp_path: Path, section: str) -> None:
    (tmp_path / "rows..of").mkdir()
    (tmp_path / "rows..of" / "monday.csv").write_text(ROWS[section])
    (tmp_path / "measurement.toml").write_text(
        DESCRIPTION.format(section=section, name='"rows..of/monday.csv"')
    )
    assert getattr(read_measurement_set(tmp_path), section) is not None


DEEP = {
    "arrays": "x = " + "[" * 5000 + "]" * 5000,
    "tables": "x = " + "{a = " * 5000 + "1" + "}" * 5000,
    "dotted key": ".".join(["x"] * 5000) + " = 1",
    "dotted section": "[" + ".".join(["x"] * 5000) + "]\n",
    "title": "title." + ".".join(["x"] * 5000) + " = 1",
    "digits": "x = " + "9" * 5000,
}


def _model(path: Path) -> None:
    read_model(path)


def _set(path: Path) -> None:
    read_measurement_set(path.parent)


@pytest.mark.parametrize("text", DEEP.values(), ids=DEEP)
@pytest.mark.parametrize(
    ("read", "fault"),
    [
        (_set, MeasurementError),
        (_model, ModelFileError),
        (read_coefficient_file, CoefficientFileError),
        (read_scenario, ScenarioError),
    ],
)
def test_deep_nesting_and_endless_numbers_are_refused_with_the_file(
    tmp_path: Path, text: str, read: Callable[[Path], object], fault: type[Exception]
) -> None:
    path = tmp_path / "measurement.toml"
    path.write_text("schema = 1\n" + text + "\n")
    with pytest.raises(fault) as caught:
        read(path)
    assert str(path) in str(caught.value)
    assert "nested" in str(caught.value) or "digits" in str(caught.value)
    assert len(str(caught.value)) < 400


def test_a_deep_setting_is_refused() -> None:
    with pytest.raises(ValueError, match="--set x="):
        settings_from(["x=" + "[" * 5000 + "]" * 5000])


def test_the_deepest_nesting_that_is_read() -> None:
    # The file itself counts as the first level.
    assert parse_toml("x = " + "[" * (DEEPEST - 1) + "]" * (DEEPEST - 1))
    with pytest.raises(TomlContentError, match="nested"):
        parse_toml("x = " + "[" * DEEPEST + "]" * DEEPEST)


@pytest.mark.parametrize("section", ["capture", "reference"])
def test_an_endless_column_name_is_refused(tmp_path: Path, section: str) -> None:
    (tmp_path / "measurement.toml").write_text(
        DESCRIPTION.format(section=section, name=f'"{section}.csv"')
    )
    (tmp_path / f"{section}.csv").write_text("x" * 200_000 + "," + ROWS[section])
    with pytest.raises(MeasurementError, match="row 1") as caught:
        read_measurement_set(tmp_path)
    assert len(str(caught.value)) < 400
