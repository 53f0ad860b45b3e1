"""Tests that ``arctrue simulate`` writes the set and the sealed truth next to it, and refuses wrong
usage."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from arctrue.cli import main
from arctrue.measurement import read_measurement_set
from arctrue.studies.simulate.truth import BrokenSealError, read_truth
from arctrue.table.registry import RECIPES, REGISTRY


def simulate(*arguments: str) -> str:
    done = CliRunner().invoke(main, ["simulate", *arguments])
    assert done.exit_code == 0, done.output
    return done.output


def test_truth_lies_next_to_the_set_and_never_in_it(tmp_path: Path) -> None:
    out = tmp_path / "bench"
    simulate(str(out), "--effect", "count_slip", "--size", "8", "--seed", "4", "--experiment=lean")
    assert sorted(file.name for file in out.iterdir()) == ["capture.csv", "measurement.toml"]
    truth = json.loads((tmp_path / "bench.truth.json").read_text(encoding="utf-8"))
    assert truth["hidden"] == "count_slip"
    assert truth["effects"][0]["size"] == 8
    assert "slip" not in (out / "measurement.toml").read_text(encoding="utf-8")
    measurement = read_measurement_set(out)
    assert measurement.warnings == ()
    assert measurement.capture is not None


def test_a_changed_set_breaks_the_seal(tmp_path: Path) -> None:
    out = tmp_path / "bench"
    simulate(str(out), "--seed", "4", "--experiment", "lean")
    assert read_truth(out)["hidden"] == "none"
    with (out / "capture.csv").open("a", encoding="utf-8") as file:
        file.write("0,99,1,1,20\n")
    with pytest.raises(BrokenSealError, match="was changed after"):
        read_truth(out)


def test_a_hidden_cause_is_not_reported(tmp_path: Path) -> None:
    out = tmp_path / "bench"
    said = simulate(str(out), "--hidden", "--seed", "6", "--experiment", "lean")
    hidden = read_truth(out)["hidden"]
    assert RECIPES[hidden].in_catalogue
    assert hidden not in said
    assert hidden not in (out / "measurement.toml").read_text(encoding="utf-8")
    simulate(str(tmp_path / "again"), "--hidden", "--seed", "6", "--experiment", "lean")
    assert read_truth(tmp_path / "again")["hidden"] == hidden


def test_simulated_again_over_itself(tmp_path: Path) -> None:
    out = tmp_path / "bench"
    simulate(str(out), "--seed", "1", "--experiment", "full")
    simulate(str(out), "--seed", "2", "--experiment", "lean")
    # A reference run that remained from the earlier set would look like a part of this set.
    assert not (out / "reference.csv").exists()
    assert read_truth(out)["seed"] == 2


def test_list_names_every_cause() -> None:
    said = simulate("--list")
    assert all(name in said for name in REGISTRY)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--effect", "friction"], "no cause is called friction"),
        (["--effect", "latency", "--hidden"], "either --hidden or --effect"),
        (["--size", "1"], "found 1 --size for 0 --effect"),
        (["--effect", "latency", "--size", "0"], "must be positive"),
    ],
)
def test_bad_usage_is_exit_code_2(tmp_path: Path, arguments: list[str], message: str) -> None:
    done = CliRunner().invoke(main, ["simulate", str(tmp_path / "x"), *arguments])
    assert done.exit_code == 2
    assert message in done.output
    assert not (tmp_path / "x").exists()


def test_noise_is_built_in_and_reported_in_the_truth(tmp_path: Path) -> None:
    out = tmp_path / "noisy"
    arguments = ("--seed", "3", "--experiment", "short", "--noise", "pink=0.05", "--noise", "gaps")
    simulate(str(out), *arguments)
    noises = json.loads((tmp_path / "noisy.truth.json").read_text(encoding="utf-8"))["noise"]
    assert [(item["noise"], item["unit"]) for item in noises] == [
        ("pink", "arcsec"),
        ("gaps", "percent"),
    ]
    assert noises[0]["size"] == 0.05


def test_noise_of_no_size_is_bad_usage(tmp_path: Path) -> None:
    done = CliRunner().invoke(main, ["simulate", str(tmp_path / "x"), "--noise", "pink=much"])
    assert done.exit_code == 2
    assert "expected a size such as pink=0.05, found 'much'" in done.output
