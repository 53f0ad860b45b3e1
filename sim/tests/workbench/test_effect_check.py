"""Tests that ``arctrue effects check`` passes correct effects and names the faults of others."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from sim.tests.workbench.small_sets import measurement_set

from arctrue.cli import main
from arctrue.measurement import write_measurement_set
from arctrue.workbench.check.effect_check import checks_of
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of

DOCS = Path(__file__).resolve().parents[3] / "docs"

SOURCE = """
import numpy as np
from arctrue.workbench.effects.base import Effect, Parameter, SearchParameter

class Mine(Effect):
    name = "mine"
    physics = equation = source = capture_sees = reference_sees = "text"
    separated_by = next_measurement = plausible = "text"
    search = (SearchParameter("tau", "s", 2.0, 60.0, "fades"),)
    {declared}
    def missing(self, observations):
        return {missing}
    def column_names(self, observations):
        return {names}
    def capture_columns(self, rows, nonlinear, context):
        since = rows.time_s - rows.run_start_s
        tau = nonlinear["tau"]
        {columns}
    def reference_columns(self, rows, nonlinear, context):
        return {reference}
    def capture_formula(self, rows, parameters, context):
        since = rows.time_s - rows.run_start_s
        a, tau = parameters.get("a", 0.0), parameters["tau"]
        return {formula}
"""
RIGHT = {
    "declared": "pass",
    "missing": "[]",
    "names": "['a']",
    "columns": "return np.exp(-since / tau)[:, None]",
    "reference": "None",
    "formula": "a * np.exp(-since / tau)",
}
TWO = "np.stack([np.exp(-since / tau), 2.0 * np.exp(-since / tau)], axis=1)"
ONES = "return np.ones((rows.run.size, 1)) * (1 + 0 * tau)"


@pytest.fixture(scope="module")
def small_set(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sets") / "small"
    write_measurement_set(folder, measurement_set(cycles=1, turns=1))
    return folder


def checked(folder: Path, small_set: Path, **changed: str) -> Result:
    path = folder / "mine.py"
    path.write_text(SOURCE.format(**{**RIGHT, **changed}), encoding="utf-8")
    words = ["effects", "check", path, "--set", small_set, "--json", folder / "c.json"]
    return CliRunner().invoke(main, [str(word) for word in words])


def found(folder: Path) -> dict[str, tuple[str, str]]:
    (effect,) = json.loads((folder / "c.json").read_text(encoding="utf-8"))["effects"]
    return {one["question"]: (one["outcome"], one["words"]) for one in effect["checks"]}


def test_a_right_effect_passes(tmp_path: Path, small_set: Path) -> None:
    done = checked(tmp_path, small_set)
    assert done.exit_code == 0, done.output
    outcomes = {question: outcome for question, (outcome, _) in found(tmp_path).items()}
    assert set(outcomes.values()) == {"right"}, found(tmp_path)
    assert "columns and formula" in outcomes


WRONG = {
    "half": (
        "columns and formula",
        {"formula": "0.5 * a * np.exp(-since / tau)"},
        "ratio 2",
    ),
    "sign": (
        "columns and formula",
        {"formula": "-a * np.exp(-since / tau)"},
        "the sign is wrong",
    ),
    "square": (
        "columns and formula",
        {"formula": "a * a * np.exp(-since / tau)"},
        "not linear in this coefficient",
    ),
    "rest": (
        "columns and formula",
        {"formula": "1.0 + a * np.exp(-since / tau)"},
        "not zero when all",
    ),
    "form": (
        "columns and formula",
        {"formula": "a * np.exp(-since / tau / 2)"},
        r"a: row \d+ has",
    ),
    "unknown": (
        "columns and formula",
        {"formula": "0.0 * since"},
        "does not contain this coefficient",
    ),
    "twice": (
        "names of the coefficients",
        {"names": "['a', 'a']", "columns": f"return {TWO}"},
        "a occurs twice",
    ),
    "zero": (
        "shape and finite values",
        {"columns": "return 0.0 * since[:, None]"},
        "a is 0 in every row",
    ),
    "nowhere": (
        "shape and finite values",
        {"columns": "return None"},
        "neither capture_columns nor",
    ),
    "random": (
        "the same rows give the same columns",
        {"columns": "return np.random.rand(since.size, 1)"},
        "a second call",
    ),
    "mean": (
        "each row by itself",
        {"columns": "return np.exp(-(since - since.mean()) / tau)[:, None]"},
        "a mean, a maximum or a first row",
    ),
    "tau": (
        "searched parameters",
        {"columns": "return np.exp(-since / 9)[:, None]"},
        "tau changes no column",
    ),
    "unit": (
        "units",
        {"declared": "parameter_units = {'a': 'furlong'}"},
        "unit 'furlong' is not known",
    ),
    "other unit": (
        "fitted parameters",
        {"declared": "parameter_units = {'a': 'deg'}"},
        "parameter_units says deg, parameters arcsec",
    ),
    "lost": (
        "fitted parameters",
        {"declared": "parameter_units = {'b': 'deg'}"},
        "b is in parameter_units",
    ),
    "offset": (
        "independence",
        {"columns": ONES, "formula": "a + 0 * since"},
        "in the offset of a run",
    ),
    "dependent": (
        "independence",
        {"names": "['a', 'b']", "columns": f"return {TWO}", "formula": "None"},
        "depend on each other",
    ),
}


@pytest.mark.parametrize(("question", "changed", "said"), WRONG.values(), ids=WRONG)
def test_what_is_wrong_is_named(
    tmp_path: Path, small_set: Path, question: str, changed: dict[str, str], said: str
) -> None:
    done = checked(tmp_path, small_set, **changed)
    assert done.exit_code == 1, done.output
    outcome, words = found(tmp_path)[question]
    assert outcome == "wrong"
    assert re.search(said, words), words
    assert f"error: {tmp_path / 'mine.py'}: wrong: mine: {question}" in done.stderr


def test_what_the_set_lacks_is_said(tmp_path: Path, small_set: Path) -> None:
    done = checked(tmp_path, small_set, missing="['a barometer']")
    assert done.exit_code == 0
    assert found(tmp_path)["columns"][0] == "open"
    assert "this set lacks a barometer" in found(tmp_path)["columns"][1]


def test_without_a_formula_nothing_is_said_to_be_compared(tmp_path: Path, small_set: Path) -> None:
    assert checked(tmp_path, small_set, formula="None").exit_code == 0
    assert found(tmp_path)["columns and formula"][0] == "open"


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"columns": "rows.time_s[:] = 0"}, "capture_columns, line 18: ValueError: assignment"),
        (
            {"columns": "return since"},
            r"capture_columns, line 15: expected an array of shape \(\d+, c",
        ),
        ({"columns": "return np.full((since.size, 1), np.nan)"}, "expected finite numbers"),
        (
            {"columns": "while True: pass", "declared": "longest_call_s = 0.2"},
            "took longer than 0.2 s",
        ),
        (
            {"formula": "np.zeros(3)"},
            r"capture_formula, line 21: expected an array of shape \(\d+,\)",
        ),
    ],
)
def test_a_method_that_fails_is_named(
    tmp_path: Path, small_set: Path, changed: dict[str, str], said: str
) -> None:
    done = checked(tmp_path, small_set, **changed)
    assert done.exit_code == 2
    assert re.match(f"error: {re.escape(str(tmp_path / 'mine.py'))}: ", done.stderr)
    assert re.search(said, done.stderr), done.stderr


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    done = CliRunner().invoke(main, ["effects", "check", str(tmp_path / "none.py")])
    assert done.exit_code == 2
    assert "none.py: no such file of effects" in done.stderr


def test_a_new_effect_passes_as_it_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert CliRunner().invoke(main, ["effects", "new", "warm_oval"]).exit_code == 0
    words = ["effects", "check", "effects/warm_oval.py", "--json", "c.json"]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 0, done.output
    outcomes = {question: outcome for question, (outcome, _) in found(tmp_path).items()}
    assert set(outcomes.values()) == {"right"}, found(tmp_path)


@pytest.fixture(scope="module")
def observations() -> Observations:
    return observations_of(measurement_set(cycles=2, turns=1))


@pytest.mark.parametrize("name", sorted(set(built_in()) - {"graduation_harmonics"}))
def test_the_catalogue_itself_passes(name: str, observations: Observations) -> None:
    """A built-in effect has no fault, except for properties that a set with one warm run cannot
    show."""
    checks = checks_of(built_in()[name], observations, built_in())
    allowed = {"independence", "shape and finite values"}
    wrong = [one for one in checks if one.outcome == "wrong" and one.question not in allowed]
    assert wrong == []
