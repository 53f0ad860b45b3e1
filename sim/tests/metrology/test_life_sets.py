"""Tests ``arctrue life`` with simulated sets of three machines, each measured ten times, and with
sets that ``arctrue life`` refuses."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from sim.tests.device.daemon_process import Replay, announcement, daemon

from arctrue.cli import main
from arctrue.device.announcement import FOLDER_VARIABLE
from arctrue.device.connection import ask
from arctrue.measurement import MeasurementSet, write_measurement_set
from arctrue.studies.simulate.experiment import short
from arctrue.studies.simulate.simulated_set import Wanted, simulate_set
from tests.workbench.small_sets import measurement_set, paper_error

BEGIN = datetime(2026, 1, 5, 9, 0, tzinfo=UTC)
SETS, DAMAGE = 10, 5
"""Number of sets, measured every two weeks, and index of the first set with the damage."""


def life(*words: object) -> Result:
    return CliRunner().invoke(main, ["life", *map(str, words)])


def write_life(folder: Path, made: Callable[[int], MeasurementSet]) -> Path:
    for number in range(SETS):
        measured = replace(made(number), date=BEGIN + timedelta(days=14 * number))
        write_measurement_set(folder / f"set_{number:02}", measured)
    return folder


def small(seed: int, **options: Any) -> MeasurementSet:
    return measurement_set(seed=seed, runs=2, turns=2, cycles=3, **options)


def worn_bearing(number: int) -> MeasurementSet:
    """Simulate a table whose axis motion grows with each set from index DAMAGE on, to 0.3 µm at the
    end."""
    size = 0.06 * max(number - DAMAGE + 1, 0)
    wear = [Wanted("radial_error_motion", size)] if size else []
    return simulate_set(wear, short(), 11, again=number).measurement


def loose_bracket(number: int) -> MeasurementSet:
    """Return a set that has a reversal error of 0.4″ from index DAMAGE on."""
    return small(200 + number, reversal_arcsec=0.4 if number >= DAMAGE else 0.0)


def crept_clamp(number: int) -> MeasurementSet:
    """Return a set whose order 2 of the disc grows by 0.1″ per set from index DAMAGE on."""
    size = 0.1 * max(number - DAMAGE + 1, 0)

    def error(disc: Any, temperature: Any, speed: float) -> Any:
        return paper_error(disc, temperature, speed) + size * np.cos(2 * disc + 1.0)

    return small(300 + number, error=error)


@pytest.fixture(scope="module")
def bracket(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_life(tmp_path_factory.mktemp("bracket"), loose_bracket)


def data(path: Path) -> dict[str, Any]:
    return dict(json.loads(path.read_text(encoding="utf-8")))


def test_a_bracket_that_loosens(bracket: Path, tmp_path: Path) -> None:
    done = life(
        bracket, "--effect", "hysteresis", "--limit", "hysteresis=1", "--json", tmp_path / "a.json",
        "--out", tmp_path,
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    found = data(tmp_path / "a.json")
    (change,) = [one for one in found["changes"] if one["name"].startswith("hysteresis")]
    assert change["kind"] == "step"
    assert change["size"] == pytest.approx(0.4, abs=4.0 * change["u"])
    last_good, first_bad = BEGIN + timedelta(days=56), BEGIN + timedelta(days=70)
    assert last_good.date().isoformat() <= change["date"] <= first_bad.date().isoformat()
    holds = [one["holds"] for one in found["calibrations"]]
    assert holds == [False] * DAMAGE + [True] * (SETS - DAMAGE)
    said = " ".join(done.output.split())
    assert f"until {last_good:%Y-%m-%d} no longer hold; hysteresis.reversal_error changed" in said
    assert f"first about {change['date']}." in said
    page = (tmp_path / "life.html").read_text(encoding="utf-8")
    assert "hysteresis.reversal_error changed in one step" in page
    assert "<svg" in page
    assert not re.search(r'(src|href)="(?!#)', page.replace("xlink:href", ""))


def test_a_clamp_that_creeps_is_an_alarm(tmp_path: Path) -> None:
    folder = write_life(tmp_path / "sets", crept_clamp)
    done = life(
        folder, "--limit", "graduation_harmonics.order_2_amplitude=1.5", "--json",
        tmp_path / "a.json",
    )  # fmt: skip
    assert done.exit_code == 1, done.output
    assert "ALARM: graduation_harmonics.order_2_amplitude" in done.output
    found = data(tmp_path / "a.json")
    assert "graduation_harmonics.order_2_amplitude" in [one["name"] for one in found["changes"]]
    (forecast,) = found["forecasts"]
    # Order 2 starts at 0.8″ and grows by 0.1″ per set: it reaches 1.5″ after 0.7″/0.1″ = 7 sets.
    # The clamp continues to creep, so that only the calibration from the last set is valid.
    assert [one["holds"] for one in found["calibrations"]] == [False] * (SETS - 1) + [True]
    passes = (BEGIN + timedelta(days=14 * (DAMAGE - 1 + 7))).date().isoformat()
    assert forecast["alarm"]
    assert not forecast["passed"]
    assert forecast["earliest"] <= passes
    assert forecast["latest"] is None or passes <= forecast["latest"]


@pytest.mark.large
def test_alarms_reach_the_daemon(
    bracket: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The daemon receives the alarms of the latest ``arctrue life`` and keeps no others; the sets
    are captures in the daemon's store."""
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "run"))
    replay, store = Replay(), tmp_path / "store"
    words = ("--effect", "hysteresis", "--limit")
    shutil.copytree(bracket, store / "captures")
    alone = life(store, *words, "hysteresis=0.3", "--device", replay.port)
    assert alone.exit_code == 2
    assert "the alarms were not sent: " in alone.output
    assert "no daemon runs" in alone.output
    with daemon(replay.port, store) as running:
        done = life(store, *words, "hysteresis=0.3", "--device", replay.port)
        assert done.exit_code == 1, done.output
        assert "sent 1 alarms to the daemon" in " ".join(done.output.split())
        name = "hysteresis.reversal_error"
        alarms = ask(announcement(replay.port), "status")["machine_alarms"]
        assert list(alarms) == [name]
        assert alarms[name].startswith(f"ALARM: {name} has passed its limit of 0.3")
        running.heard(f"history of the machine: {alarms[name]}")
        done = life(store, *words, "hysteresis=5", "--device", replay.port)
        assert done.exit_code == 0, done.output
        assert ask(announcement(replay.port), "status")["machine_alarms"] == {}
        running.heard(f"{name}: its alarm has ended")


@pytest.mark.large
def test_a_bearing_that_wears(tmp_path: Path) -> None:
    folder = write_life(tmp_path / "sets", worn_bearing)
    done = life(folder, "--effect", "radial_error_motion", "--json", tmp_path / "a.json")
    assert done.exit_code == 0, done.output
    names = [one["name"] for one in data(tmp_path / "a.json")["changes"]]
    assert any(name.startswith("radial_error_motion.") for name in names), names


def test_what_cannot_be_used_is_listed(bracket: Path, tmp_path: Path) -> None:
    folder = tmp_path / "sets"
    shutil.copytree(bracket, folder)
    shutil.copytree(folder / "set_03", folder / "copy")
    text = (folder / "set_01" / "measurement.toml").read_text(encoding="utf-8")
    without = "\n".join(line for line in text.splitlines() if not line.startswith("date"))
    (folder / "set_01" / "measurement.toml").write_text(without, encoding="utf-8")
    (folder / "set_02" / "capture.csv").write_text("nonsense\n", encoding="utf-8")
    other = (folder / "set_09" / "measurement.toml").read_text(encoding="utf-8")
    (folder / "set_09" / "measurement.toml").write_text(
        other.replace("head_separation_deg = 33.0", "head_separation_deg = 33.2"), encoding="utf-8"
    )
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    done = life(folder, "--json", tmp_path / "a.json")
    assert done.exit_code == 0, done.output
    found = data(tmp_path / "a.json")
    reasons = {one["name"]: one["reason"] for one in found["refused"]}
    assert set(reasons) == {"set_01", "set_02", "set_03", "set_09"}
    assert "states no date; add a line such as date = 2026-03-12" in reasons["set_01"]
    assert "capture.csv, row 1" in reasons["set_02"]
    assert reasons["set_03"] == "is the same set as copy; one of them is used"
    assert "is of another table than copy" in reasons["set_09"]
    assert len(found["sets"]) == SETS - 3
    for name, reason in reasons.items():
        assert f"{name}: {reason}" in " ".join(done.stderr.split())
    assert before == {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--limit", "hysterese=1"], "no effect of that name has a parameter in arcseconds"),
        (["--limit", "graduation_harmonics"], "expected EFFECT=SIZE such as hysteresis=0.5"),
        (["--limit", "graduation_harmonics=-1"], "expected a size above 0"),
        (["--effect", "histeresis"], "did you mean hysteresis?"),
    ],
)
def test_wrong_words_are_refused(tmp_path: Path, words: list[str], said: str) -> None:
    write_measurement_set(tmp_path / "one", replace(small(1), date=BEGIN))
    done = life(tmp_path, *words)
    assert done.exit_code == 2
    assert said.lower() in " ".join(done.stderr.split()).lower()


def test_a_folder_without_sets_is_refused(tmp_path: Path) -> None:
    done = life(tmp_path)
    assert done.exit_code == 2
    assert "holds no measurement sets" in " ".join(done.stderr.split())


@pytest.mark.filterwarnings("error:Attempting to set identical")
def test_the_page_of_the_first_set_has_an_axis(tmp_path: Path) -> None:
    """The page of a machine with one set, whose dates have no extent, is drawn without warnings."""
    write_measurement_set(tmp_path / "sets" / "one", replace(small(1), date=BEGIN))
    done = life(tmp_path / "sets", "--out", tmp_path / "page")
    assert done.exit_code == 0, done.output
    page = (tmp_path / "page" / "life.html").read_text(encoding="utf-8")
    assert f"{BEGIN:%Y-%m-%d}" in page
