"""Tests that a model and the user's effects can be moved together, and that the model's steps state
date, program and set."""

from __future__ import annotations

import hashlib
import re
import shutil
import subprocess
from datetime import UTC, datetime, timedelta
from importlib.metadata import version
from pathlib import Path

import pytest
from click.testing import CliRunner
from sim.tests.workbench.small_sets import measurement_set

from arctrue.cli import main
from arctrue.measurement import write_measurement_set
from arctrue.measurement.digest import set_digest
from arctrue.workbench.model.model_file import folder_entry, read_model


def _run(*words: object) -> str:
    done = CliRunner().invoke(main, [str(word) for word in words])
    assert done.exit_code == 0, done.output
    return done.output


def test_a_model_with_its_effects_can_be_moved(tmp_path: Path) -> None:
    here, there = tmp_path / "here", tmp_path / "elsewhere" / "there"
    write_measurement_set(here / "set", measurement_set(turns=1, cycles=2))
    _run("effects", "new", "my_own", "--folder", here / "effects")
    began = datetime.now(UTC) - timedelta(seconds=1)
    model = here / "models" / "table.toml"
    _run("add", "my_own", here / "set", "--effects", here / "effects", "--model", model)
    assert read_model(model).folders == ["../effects"]
    assert str(tmp_path) not in model.read_text(encoding="utf-8")

    there.parent.mkdir()
    shutil.move(here, there)
    moved = there / "models" / "table.toml"
    assert "my_own" in _run("compare", there / "set", "--model", moved)

    for step in read_model(moved).history:
        assert began <= datetime.fromisoformat(step.date) <= datetime.now(UTC)
        assert step.program == f"arctrue {version('arctrue')}"
        assert re.fullmatch(r"[0-9a-f]{64}", step.measurement_sha256)
        assert step.measurement_sha256 == set_digest(there / "set")

    # A further step keeps the statements of earlier steps, and does not list the folder a second
    # time.
    earlier = read_model(moved).history
    _run("add", "hysteresis", there / "set", "--effects", there / "effects", "--model", moved)
    later = read_model(moved)
    assert later.history[: len(earlier)] == earlier
    assert later.folders == ["../effects"]


def test_the_digest_is_that_of_common_tools(tmp_path: Path) -> None:
    write_measurement_set(tmp_path, measurement_set(turns=1, cycles=1))
    names = ("measurement.toml", "capture.csv", "reference.csv")
    listed = subprocess.run(["sha256sum", *names], cwd=tmp_path, capture_output=True, check=True)
    before = set_digest(tmp_path)
    assert before == hashlib.sha256(listed.stdout).hexdigest()
    with (tmp_path / "capture.csv").open("a") as file:
        file.write("\n")
    assert set_digest(tmp_path) != before


def test_a_set_that_is_as_it_was_is_not_read_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_measurement_set(tmp_path, measurement_set(turns=1, cycles=1))
    before = set_digest(tmp_path)
    monkeypatch.setattr(hashlib, "file_digest", None)
    assert set_digest(tmp_path) == before


def test_folders_are_named_from_the_model_file(tmp_path: Path) -> None:
    assert folder_entry(tmp_path / "m.toml", tmp_path / "a" / "b") == "a/b"
    assert folder_entry(tmp_path / "x" / "m.toml", tmp_path / "a") == "../a"
    assert folder_entry(tmp_path / "m.toml", tmp_path) == "."
