"""Tests that docs/measurement-set.md has the reader's keys and columns, and a valid example."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import get_type_hints

import numpy as np
import pytest

from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.calibration import calibrate
from arctrue.measurement import read_measurement_set
from arctrue.measurement.description import SECTIONS, CaptureKeys, Keys, ReferenceKeys
from arctrue.measurement.measurement_set import (
    CAPTURE_COLUMNS,
    CAPTURE_OPTIONAL,
    REFERENCE_COLUMNS,
    REFERENCE_OPTIONAL,
    Origin,
    Table,
)

PAGE = Path(__file__).resolve().parents[3] / "docs" / "measurement-set.md"


def block(language: str) -> str:
    found = re.search(rf"```{language}\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert found
    return found[1]


def columns_under(heading: str) -> set[str]:
    (section,) = re.findall(
        rf"^## {heading}\n(.*?)(?=^## )", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
    )
    first_cells = re.findall(r"^\| (`.*?) \|", section, re.MULTILINE)
    return {name for cell in first_cells for name in re.findall(r"`(\w+)`", cell)}


def test_every_key_of_the_reader_and_no_other() -> None:
    content = tomllib.loads(block("toml"))
    sections = {"": Keys, "table": Table, "capture": CaptureKeys, "reference": ReferenceKeys}
    for section, declared in {**sections, "origin": Origin}.items():
        keys = set(get_type_hints(declared)) - set(SECTIONS)
        given = content if section == "" else content[section]
        own = {key for key, value in given.items() if not isinstance(value, dict)}
        # The key for the number of faces may be in the section of the table or of the reference.
        # The places of three or four heads replace the separation of two heads.
        elsewhere = {"faces", "head_places_deg"} if section == "table" else set()
        assert own == keys - elsewhere, section
    assert "# head_places_deg = [0.0, " in block("toml")


def test_every_column_of_the_reader_and_no_other() -> None:
    assert columns_under("capture.csv") == {*CAPTURE_COLUMNS, *CAPTURE_OPTIONAL}
    assert columns_under("reference.csv") == {*REFERENCE_COLUMNS, *REFERENCE_OPTIONAL}


def test_the_example_is_calibrated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    exec(compile(block("python"), str(PAGE), "exec"), {})
    found = calibrate(read_measurement_set(tmp_path / "my_table"))
    amplitude, u = found.estimate.amplitude_arcsec, found.estimate.u_amplitude_arcsec
    # The example has an amplitude of 30″; its only noise is the rounding to counts, which u
    # includes.
    assert amplitude[0] == pytest.approx(30.0, abs=5.0 * u[0])
    assert u[0] < 0.1
    # An error a·cos θ, as a function of the reading, also has an order 2 with amplitude a²/2
    # (docs/errata.md).
    second = 30.0**2 / 2.0 / ARCSEC_PER_RAD
    assert amplitude[1] == pytest.approx(second, abs=5.0 * u[1])
    assert np.all(amplitude[2:] < 5.0 * u[2:])
    assert found.warnings == ()
