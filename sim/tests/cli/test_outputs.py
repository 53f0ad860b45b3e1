"""Tests that a command checks its output's path before it works, and overwrites no recorded set."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from filelock import Timeout
from sim.tests.command_line import arctrue

from arctrue.workbench.model.model_file import model_lock

SCENARIO = Path(__file__).resolve().parents[2] / "scenarios" / "hysteresis.toml"


@pytest.fixture
def no_instrument(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fail the test if a command starts to build the instrument."""

    def built(*_: object, **__: object) -> None:
        raise AssertionError("the command began to build before it checked the path of its output")

    monkeypatch.setattr("arctrue.instrument.instrument.build", built)


@pytest.mark.usefixtures("no_instrument")
@pytest.mark.parametrize(
    "command",
    [
        ["revolution", "--json"],
        ["revolution", "--picture"],
        ["paper", "--json"],
        ["paper", "--out"],
        ["run", str(SCENARIO), "--json"],
        ["run", str(SCENARIO), "--out"],
        ["hidden", "hysteresis", "--out"],
        ["hidden", "hysteresis", "--json"],
        ["demo", "--out"],
    ],
    ids=" ".join,
)
def test_a_place_below_a_file_is_refused_before_the_work(
    command: list[str], tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("kept")
    done = arctrue(*command, tmp_path / "file" / "result.svg")
    assert done.exit_code == 2, done.output
    assert "is a file; name a folder" in done.output
    assert (tmp_path / "file").read_text() == "kept"


@pytest.mark.usefixtures("no_instrument")
def test_a_picture_of_an_unknown_kind_is_refused_before_the_work(tmp_path: Path) -> None:
    done = arctrue("revolution", "--picture", tmp_path / "turn.jpeg2")
    assert done.exit_code == 2
    assert ".svg, .png, .pdf" in done.output


@pytest.mark.parametrize("option", ["--json", "--out"])
@pytest.mark.parametrize("below", ["", "/below"])
def test_a_name_that_no_file_can_have_is_refused_before_the_work(
    option: str, below: str, tmp_path: Path
) -> None:
    name = f"{'long' * 100}{below}"  # a name has at most 255 bytes
    done = arctrue("compare", tmp_path / "no set", option, tmp_path / name)
    assert done.exit_code == 2
    assert "File name too long; name another place" in done.output
    assert option in done.output


def test_a_folder_in_place_of_a_file_is_reported(tmp_path: Path) -> None:
    done = arctrue("history", "--model", "any.toml", "--json", tmp_path)
    assert done.exit_code == 2
    assert "directory" in done.output


@pytest.mark.parametrize(
    ("option", "name"),
    [
        (["compare", "--json"], "reference.csv"),
        (["compare", "--json"], "capture.csv"),
        (["export", "--coefficients"], "measurement.toml"),
    ],
    ids=lambda item: " ".join(item) if isinstance(item, list) else item,
)
def test_no_file_of_a_set_is_overwritten(option: list[str], name: str, tmp_path: Path) -> None:
    out = tmp_path / "monday"
    arctrue("simulate", out, "--effect", "hysteresis", "--seed", "1", "--experiment", "one_pass")
    before = (out / name).read_bytes()
    command, output = option
    done = arctrue(command, out, output, out / name)
    assert done.exit_code == 2, done.output
    assert "belongs to the measurement set" in done.output
    assert (out / name).read_bytes() == before


def test_the_model_is_not_overwritten(tmp_path: Path) -> None:
    out, model = tmp_path / "monday", tmp_path / "model.toml"
    arctrue("simulate", out, "--effect", "hysteresis", "--seed", "1", "--experiment", "one_pass")
    assert arctrue("add", "hysteresis", out, "--model", model).exit_code == 0
    before = model.read_bytes()
    done = arctrue("compare", out, "--model", model, "--json", model)
    assert done.exit_code == 2, done.output
    assert "name another file" in done.output
    assert model.read_bytes() == before


@pytest.mark.parametrize("name", ["-", "/dev/null"])
def test_a_result_goes_to_an_ordinary_file_only(name: str, tmp_path: Path) -> None:
    done = arctrue("compare", tmp_path / "no set", "--json", name)
    assert done.exit_code == 2
    assert "file" in done.output
    assert "--json" in done.output
    assert not Path("-").exists()


def test_a_file_of_effects_is_a_python_file(tmp_path: Path) -> None:
    (tmp_path / "effect.bin").write_bytes(b"\0\1")
    done = arctrue("effects", "check", tmp_path / "effect.bin")
    assert done.exit_code == 2, done.output
    assert "ends in .py" in done.output


def test_a_lock_that_cannot_be_made_is_reported(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise Timeout(str(tmp_path / "lock"))

    monkeypatch.setattr("arctrue.workbench.model.model_file.FileLock.acquire", refuse)
    with pytest.raises(PermissionError), model_lock(tmp_path / "model.toml"):
        pass


def test_a_recorded_set_is_not_simulated_over(tmp_path: Path) -> None:
    out = tmp_path / "monday"
    simulate = ("simulate", out, "--effect", "hysteresis", "--seed", "1", "--experiment", "lean")
    assert arctrue(*simulate).exit_code == 0
    # ``arctrue simulate`` may overwrite a set that has a truth file, because it made this set
    # itself.
    assert arctrue(*simulate).exit_code == 0
    (tmp_path / "monday.truth.json").unlink()
    before = (out / "capture.csv").read_bytes()
    done = arctrue(*simulate[:-2], "--experiment", "short")
    assert done.exit_code == 2
    assert "holds a measurement set already" in done.output
    assert (out / "capture.csv").read_bytes() == before


def test_a_recorded_set_is_not_captured_over(tmp_path: Path) -> None:
    (tmp_path / "measurement.toml").write_text("schema = 1")
    done = arctrue("capture", "/dev/no_such_port", tmp_path)
    assert done.exit_code == 2
    assert "holds a measurement set already" in done.output


def test_without_generated_modules_it_is_said_how_to_make_them() -> None:
    # Python cannot import a module that is None in sys.modules.
    program = "import sys; sys.modules['arctrue.generated'] = None; import arctrue.cli as cli; "
    done = subprocess.run(
        [sys.executable, "-c", program + "cli.main()", "calibrate", "--help"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert "make generate" in done.stderr
    assert "Traceback" not in done.stderr


def test_swapped_heads_are_reported_by_the_workbench_too(tmp_path: Path) -> None:
    out = tmp_path / "swapped"
    arctrue("simulate", out, "--effect", "hysteresis", "--seed", "1", "--experiment", "lean")
    capture = out / "capture.csv"
    text = capture.read_text()
    assert text.startswith("run,time_s,head1_counts,head2_counts")
    capture.write_text(text.replace("head1_counts,head2_counts", "head2_counts,head1_counts", 1))
    calibrate = ("calibrate", out, "--out", tmp_path / "calibrated")
    for command in (("compare", out), calibrate):
        assert "head1_counts and head2_counts swapped?" in arctrue(*command).output
