"""Tests of the workbench's commands, with files as input, and text, JSON and pictures as output."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sim.tests.command_line import arctrue as _run
from sim.tests.workbench.small_sets import measurement_set, paper_error

from arctrue.gateware.coefficient_file import read_coefficient_file
from arctrue.measurement import MeasurementSet, Reference, Table, write_measurement_set
from arctrue.workbench.effects.registry import ORDER
from arctrue.workbench.model.model_file import read_model


def _warm_error(disc, temperature, speed):  # type: ignore[no-untyped-def]
    return paper_error(disc, temperature, speed) + 0.4 * (temperature - 20.0) * np.cos(disc + 0.7)


@pytest.fixture(scope="module")
def warm_set(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sets") / "warm"
    write_measurement_set(folder, measurement_set(_warm_error))
    return folder


@pytest.fixture(scope="module")
def same_table_again(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sets") / "again"
    write_measurement_set(folder, measurement_set(_warm_error, seed=2))
    return folder


def _json(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


@pytest.mark.large
def test_the_loop_by_hand(warm_set: Path, same_table_again: Path, tmp_path: Path) -> None:
    """Run compare, diagnose, add, compare with another set of the same table, history, export and
    drop."""
    model = tmp_path / "model.toml"
    pictures = tmp_path / "pictures"

    compared = _run("compare", warm_set, "--out", pictures, "--json", tmp_path / "c.json")
    assert compared.exit_code == 0, compared.output
    assert "temperature × order 1" in compared.output
    # The residual of the capture contains an effect that the model lacks; the residual is therefore
    # correlated and fails the test of whiteness. The residual of the reference is white noise.
    assert "residual of the capture fails a test: an effect is" in compared.output
    assert _json(tmp_path / "c.json")["noise"]["reference"]["tests"]["normality_p"] > 0.001
    assert {path.name for path in pictures.iterdir()} == {
        "residual_branches.png",
        "residual_findings.png",
        "residual_maps.png",
        "residual_lines.png",
        "residual_whitened.png",
    }

    diagnosed = _run("diagnose", warm_set, "--json", tmp_path / "d.json")
    assert "–: not calculated." in diagnosed.output
    assert diagnosed.exit_code == 0, diagnosed.output
    data = _json(tmp_path / "d.json")
    assert data["schema"] == 2
    assert (data["verdict"], data["named"]) == ("named", "thermal_eccentricity")
    assert data["candidates"][0]["effect"] == "thermal_eccentricity"
    assert data["class"][0] == "thermal_eccentricity"

    added = _run("add", data["named"], warm_set, "--model", model, "--json", tmp_path / "a.json")
    assert added.exit_code == 0, added.output
    step = _json(tmp_path / "a.json")
    assert step["verdict_after"] == "adequate"
    noise = step["noise_arcsec"]["capture"]
    assert step["rms_before_arcsec"]["capture"] > 2.0 * noise
    assert step["heldout_after_arcsec"]["capture"] < 1.05 * noise
    assert [entry.name for entry in read_model(model).effects] == [
        "graduation_harmonics",
        "thermal_eccentricity",
    ]

    judged = _run(
        "compare", same_table_again, "--model", model, "--no-fit", "--json", tmp_path / "n.json"
    )
    assert judged.exit_code == 0, judged.output
    channels = _json(tmp_path / "n.json")["channels"]
    assert channels["capture"]["rms_arcsec"] < 1.05 * channels["capture"]["noise_arcsec"]

    reported = _run("history", "--model", model, "--out", pictures)
    assert reported.exit_code == 0, reported.output
    assert (pictures / "history.png").stat().st_size > 10_000

    exported = _run("export", warm_set, "--model", model, "--temperature", 24, "--out", tmp_path)
    assert exported.exit_code == 0, exported.output
    coefficients = read_coefficient_file(tmp_path / "coefficients.toml")
    reading = np.arange(0, 1 << 24, 65_537)
    angle = reading * (2.0 * np.pi / (1 << 24))
    error = np.zeros(angle.size)
    for _ in range(5):
        error = _warm_error(angle - error * np.pi / 648_000.0, 24.0, 0.0)
    left = coefficients.error_counts(reading) * (1_296_000.0 / (1 << 24)) - error
    assert np.max(np.abs(left - left.mean())) < 0.06

    dropped = _run("drop", "thermal_eccentricity", warm_set, "--model", model)
    assert dropped.exit_code == 0, dropped.output
    assert read_model(model).names() == ["graduation_harmonics"]
    assert [step.action for step in read_model(model).history] == ["fit", "add", "drop"]


@pytest.mark.large
def test_an_unknown_effect_is_adopted_and_the_error_falls(tmp_path: Path) -> None:
    def error(disc, temperature, speed):  # type: ignore[no-untyped-def]
        return paper_error(disc, temperature, speed) + 0.4 * (temperature - 20.0) * np.cos(
            2 * disc + 0.7
        )

    folder, effects, model = tmp_path / "set", tmp_path / "effects", tmp_path / "m.toml"
    write_measurement_set(folder, measurement_set(error))
    diagnosed = _run(
        "diagnose", folder, "--json", tmp_path / "d.json", "--adopt", "warm_ovality",
        "--folder", effects,
    )  # fmt: skip
    assert diagnosed.exit_code == 0, diagnosed.output
    data = _json(tmp_path / "d.json")
    assert data["verdict"] == "unknown"
    assert data["named"] is None
    assert data["parts"] == ["temperature", "order:2", "disc"]
    added = _run("add", "warm_ovality", folder, "--effects", effects, "--model", model,
                 "--json", tmp_path / "a.json")  # fmt: skip
    assert added.exit_code == 0, added.output
    step = _json(tmp_path / "a.json")
    assert step["verdict_after"] == "adequate"
    assert step["heldout_after_arcsec"]["capture"] < 1.05 * step["noise_arcsec"]["capture"]
    # The model file names the file of the effect, so that --effects is no longer needed.
    assert _run("compare", folder, "--model", model).exit_code == 0


def test_a_setting_is_changed_by_adding_again(warm_set: Path, tmp_path: Path) -> None:
    model = tmp_path / "m.toml"
    first = _run("add", "thermal_eccentricity", warm_set, "--model", model)
    assert first.exit_code == 0, first.output
    changed = _run(
        "add", "graduation_harmonics", warm_set, "--model", model, "--set", "orders=[1, 2, 3]"
    )
    assert changed.exit_code == 0, changed.output
    found = read_model(model)
    assert sorted(found.names()) == ["graduation_harmonics", "thermal_eccentricity"]
    place = found.names().index("graduation_harmonics")
    assert found.effects[place].settings == {"orders": [1, 2, 3]}
    assert len(found.effects[place].coefficients) == 6
    assert [step.action for step in found.history] == ["fit", "add", "set"]
    # Order 5 has 0.4″; without it the error rises.
    assert found.history[-1].rms_arcsec["capture"] > 2.0 * found.history[-2].rms_arcsec["capture"]
    again = _run(
        "add", "graduation_harmonics", warm_set, "--model", model, "--set", "orders=[1, 2, 3]"
    )
    assert again.exit_code == 2
    assert "changes one of its settings" in again.output


def test_effects_are_listed_and_shown(tmp_path: Path) -> None:
    listed = _run("effects", "--json", tmp_path / "e.json")
    assert listed.exit_code == 0
    assert len(_json(tmp_path / "e.json")["effects"]) == len(ORDER) + len(["product_of_parts"])
    shown = _run("effects", "show", "hysteresis", "--json", tmp_path / "h.json")
    assert shown.exit_code == 0
    assert _json(tmp_path / "h.json")["parameters"] == {"reversal_error": "arcsec"}


def test_a_wrong_row_is_left_out_unless_every_row_is_asked_for(tmp_path: Path) -> None:
    made = measurement_set(runs=1, turns=2, reference=False)
    assert made.capture is not None
    made.capture.head2_counts[700] += 4000
    write_measurement_set(tmp_path / "set", made)
    for options, masked in ((), 1), (("--keep-outliers",), 0):
        done = _run("compare", tmp_path / "set", "--json", tmp_path / "c.json", *options)
        assert done.exit_code == 0, done.output
        assert ("rows are not used" in done.output) == bool(masked)
        assert len(_json(tmp_path / "c.json")["masked"]) == masked


def _bad_commands(good: Path, folder: Path) -> dict[str, tuple[object, ...]]:
    other = folder / "other.toml"
    other.write_text('schema = 1\n[[effect]]\nname = "nonsense"\n', encoding="utf-8")
    for name, table in (("setting", "[effect.settings]"), ("search", "[effect.search]")):
        text = f'schema = 1\n[[effect]]\nname = "vibration"\n{table}\nfrequncy = 3\n'
        (folder / f"{name}.toml").write_text(text, encoding="utf-8")
    return {
        "setting.toml: effect[1]: effect vibration: unknown setting frequncy": (
            *("compare", good, "--model", folder / "setting.toml"),
        ),
        "search.toml: effect[1]: effect vibration: unknown search parameter frequncy. Did you": (
            *("compare", good, "--model", folder / "search.toml"),
        ),
        "no such": ("compare", folder / "nowhere"),
        "no effect is named 'nonsense'": ("compare", good, "--model", other),
        "none.toml: no such file": ("compare", good, "--model", folder / "none.toml"),
        "no effect is named 'hysterese'": ("add", "hysterese", good),
        "cannot be tested with this set": ("add", "drive_gear_error", good),
        "the model has graduation_harmonics already": ("add", "graduation_harmonics", good),
        "has no hysteresis": ("drop", "hysteresis", good),
        "expected KEY=VALUE": ("add", "subdivision_error", good, "--set", "multiples"),
        "unknown setting": ("add", "subdivision_error", good, "--set", "x=1"),
        "nothing to adopt": ("diagnose", good, "--adopt", "mine"),
        "no coefficients": ("compare", good, "--no-fit"),
    }


@pytest.mark.large
def test_bad_input_is_one_sentence_and_exit_code_2(warm_set: Path, tmp_path: Path) -> None:
    for said, arguments in _bad_commands(warm_set, tmp_path).items():
        result = _run(*arguments)
        assert result.exit_code == 2, (arguments, result.output, result.exception)
        assert said in result.output, (arguments, result.output)
        assert isinstance(result.exception, SystemExit)


def test_a_channel_without_an_unmasked_row_is_refused(tmp_path: Path) -> None:
    measured = measurement_set(runs=1, cycles=2)
    assert measured.capture is not None
    assert measured.reference is not None
    for channel, rows in (
        ("capture", measured.capture.run.size),
        ("reference", measured.reference.error_arcsec.size),
    ):
        masked = replace(getattr(measured, channel), mask=np.ones(rows, dtype=bool))
        folder = tmp_path / channel
        write_measurement_set(folder, replace(measured, **{channel: masked}))
        for command in ("compare", "iso230"):
            done = _run(command, folder)
            assert done.exit_code == 2
            assert f"the {channel}: all {rows:,} rows are masked" in done.output
    refused = _run("calibrate", tmp_path / "capture")
    assert refused.exit_code == 3
    assert "run 0: it has 0 samples that are not masked" in refused.output


def test_a_reference_of_one_row_is_diagnosed(tmp_path: Path) -> None:
    """The diagnosis leaves out a quarter of the rows at a time; with one row, some quarters are
    empty."""
    rows = Reference(target_deg=np.array([15.0]), error_arcsec=np.array([2.0]))
    write_measurement_set(tmp_path / "one", MeasurementSet(Table(), reference=rows))
    done = _run("diagnose", tmp_path / "one", "--json", tmp_path / "one.json")
    assert done.exit_code == 0, done.output
    assert _json(tmp_path / "one.json")["verdict"] == "cannot_tell"
