"""Tests that the workbench's commands and its page accept a capture of four heads."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from sim.tests.command_line import arctrue

from arctrue.measurement import write_measurement_set
from arctrue.page.app import make_page
from arctrue.page.jobs import Jobs
from arctrue.page.settings import PageSettings
from tests.workbench.heads.four_heads import FourHeads, ball_pass


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write the set of a table whose axis has a ball-pass motion of 0.25 µm."""
    path = tmp_path_factory.mktemp("sets") / "ball"
    world = FourHeads(motion=ball_pass(0.25e-6, 4.37), samples=500)
    write_measurement_set(path, world.measured(7))
    return path


@pytest.fixture(scope="module")
def explained(folder: Path) -> Path:
    model = folder.parent / "model.toml"
    answer = arctrue("explain", str(folder), "--model", str(model))
    assert answer.exit_code == 0, answer.output
    assert "bearing_ball_pass" in answer.output
    # The answer qualifies its probabilities, because the probabilities were calibrated on sets with
    # two heads.
    assert "its capture has 4 heads" in " ".join(answer.output.split())
    return model


@pytest.mark.large
@pytest.mark.parametrize("command", ["compare", "diagnose", "report"])
def test_the_command_reads_four_heads(command: str, folder: Path, tmp_path: Path) -> None:
    answer = arctrue(command, str(folder), "--out", str(tmp_path)) if command != "diagnose" else (
        arctrue(command, str(folder))
    )  # fmt: skip
    assert answer.exit_code == 0, answer.output
    assert "Traceback" not in answer.output


@pytest.mark.large
def test_a_fresh_set_is_judged_by_the_stored_model(explained: Path, tmp_path: Path) -> None:
    """The stored model leaves only the noise of the readings in a new set, to which it is not
    fitted."""
    fresh = tmp_path / "fresh"
    world = FourHeads(motion=ball_pass(0.25e-6, 4.37), samples=500)
    write_measurement_set(fresh, world.measured(8))
    figures = tmp_path / "figures.json"
    answer = arctrue(
        "compare", str(fresh), "--no-fit", "--model", str(explained), "--json", str(figures)
    )
    assert answer.exit_code == 0, answer.output
    left = json.loads(figures.read_text())["channels"]["capture"]["rms_arcsec"]
    # R₂ − R₁ contains the noise of two readings of 0.1″ and their rounding to counts of 0.077″.
    assert left < 1.1 * 2**0.5 * (0.1**2 + 0.077**2 / 12.0) ** 0.5


@pytest.mark.large
def test_the_mean_takes_the_motion_away(explained: Path, folder: Path, tmp_path: Path) -> None:
    figures = tmp_path / "figures.json"
    answer = arctrue(
        "export", str(folder), "--model", str(explained), "--out", str(tmp_path),
        "--json", str(figures), "--force",
    )  # fmt: skip
    assert "calibrate --angle mean" in answer.output
    became = json.loads(figures.read_text())
    by = {item["effect"]: item for item in became["effects"]}
    assert by["bearing_ball_pass"]["by"] == "the mean"
    assert by["bearing_ball_pass"]["left_arcsec"] == 0.0
    # In head 1 the y component of a circle of 0.25 µm remains, at a radius of 54 mm.
    assert became["left_arcsec"] == pytest.approx(0.955 / 2**0.5, rel=0.05)


def test_the_page_opens_four_heads(folder: Path, tmp_path: Path) -> None:
    """The page lists each run once for each further head, for example as "3 head 4", and states the
    run numbers of the set, which end at 3."""
    settings = PageSettings(folder.parent, tmp_path / "state")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Jobs, "start", lambda *_: None)
        with make_page(settings).app.test_client() as client:
            address = str(client.post("/open", data={"set": folder.name}).location)
            page = client.get(address)
    assert page.status_code == 200
    assert "3 head 4" in page.text
    assert "4 head" not in page.text
