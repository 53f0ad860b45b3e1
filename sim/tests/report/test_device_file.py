"""Tests that the page's coefficient file is the file of ``arctrue export``."""

from __future__ import annotations

from pathlib import Path

import pytest
from sim.tests.command_line import arctrue

from arctrue.gateware.coefficient_file import read_coefficient_file
from arctrue.measurement import read_measurement_set
from arctrue.report.analysis import analyse
from arctrue.report.display import temperature_fault
from arctrue.report.ranking import device_data
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.model.model_file import read_model


@pytest.fixture(scope="module")
def warm(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a simulated set whose order 1 follows the temperature."""
    folder = tmp_path_factory.mktemp("warm")
    made = arctrue(
        *("simulate", folder / "set", "--effect", "thermal_eccentricity"),
        *("--seed", "1", "--experiment", "short"),
    )
    assert made.exit_code == 0, made.output
    added = arctrue("add", "thermal_eccentricity", folder / "set", "--model", folder / "model.toml")
    assert added.exit_code == 0, added.output
    return folder


@pytest.mark.parametrize("celsius", [None, 25.0])
def test_the_file_of_the_page_is_that_of_export(warm: Path, celsius: float | None) -> None:
    file = warm / f"{celsius}.toml"
    options = [] if celsius is None else ["--temperature", str(celsius)]
    command = ("export", warm / "set", "--model", warm / "model.toml", "--coefficients", file)
    assert arctrue(*command, *options).exit_code == 0
    analysis = analyse(
        read_measurement_set(warm / "set"), "set", read_model(warm / "model.toml"), built_in()
    )
    device = device_data(analysis, celsius)
    assert device["has_temperature"]
    assert device["follows"] == (celsius is None)
    (warm / "page.toml").write_text(device["file"])
    assert read_coefficient_file(warm / "page.toml") == read_coefficient_file(file)
    # At the station temperatures of the reference, the correction makes the largest error smaller.
    _, before, after = device["at_reference"]
    assert max(map(abs, after)) < max(map(abs, before))


@pytest.mark.parametrize("text", ["abc", "1e9", "-500", "nan"])
def test_a_temperature_that_cannot_be_used_is_reported(text: str) -> None:
    assert temperature_fault(text).startswith(f"{text}: expected a temperature from")
    assert not temperature_fault("21,5")
    assert not temperature_fault("")
