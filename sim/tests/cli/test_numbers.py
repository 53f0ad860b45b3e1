"""Tests that no option accepts nan, inf, or a negative number where only positive ones make
sense."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from sim.tests.workbench.small_sets import measurement_set

from arctrue.cli import main
from arctrue.cli._settings import settings_from
from arctrue.measurement import write_measurement_set

SIGNED = {
    ("calibrate", "separation"),
    ("budget", "temperature"),
    ("iso230", "temperature"),
    ("export", "temperature"),
    ("import", "separation"),
    ("import", "clock_offset"),
    ("import", "rate"),
    ("simulate", "sizes"),
    ("calibrate", "runs"),
    ("certificate", "temperature"),
    ("load", "turn"),
}
"""Options that may be negative: angles, speeds, temperatures in °C, clocks, sizes of causes,
numbers of runs and turns."""


def _numeric() -> Iterator[tuple[click.Context, str, click.Parameter]]:
    context = click.Context(main)
    for name in main.list_commands(context):
        command = main.get_command(context, name)
        assert command is not None
        for parameter in command.params:
            if isinstance(parameter.type, click.types.FloatParamType | click.types.IntParamType):
                yield context, name, parameter


def test_there_are_numeric_options() -> None:
    assert {("diagnose", "matters"), ("export", "temperature"), ("monitor", "silence")} <= {
        (name, parameter.name) for _, name, parameter in _numeric()
    }


@pytest.mark.parametrize("text", ["nan", "NaN", "inf", "-inf", "Infinity", "1e999", "", "½"])
def test_what_is_no_finite_number_is_refused(text: str) -> None:
    for context, name, parameter in _numeric():
        with pytest.raises(click.BadParameter):
            pytest.fail(f"{name} {parameter.name}: {parameter.type.convert(text, None, context)}")


def test_negative_numbers_are_refused_where_they_mean_nothing() -> None:
    for context, name, parameter in _numeric():
        if (name, parameter.name) in SIGNED:
            continue
        with pytest.raises(click.BadParameter):
            pytest.fail(f"{name} {parameter.name}: {parameter.type.convert('-1', None, context)}")


@pytest.mark.parametrize("pair", ["size=nan", "size=inf", "size=-inf", "orders=[1, nan]"])
def test_a_setting_that_is_not_finite_is_refused(pair: str) -> None:
    with pytest.raises(ValueError, match="finite"):
        settings_from([pair])


def test_a_threshold_that_is_no_number_gives_no_verdict(tmp_path: Path) -> None:
    write_measurement_set(tmp_path / "set", measurement_set(cycles=1, turns=1))
    done = CliRunner().invoke(main, ["diagnose", str(tmp_path / "set"), "--matters", "nan"])
    assert done.exit_code == 2
    assert "nan" in done.output
    assert "adequate" not in done.output
