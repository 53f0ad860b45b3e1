"""Tests of small scenarios on the compiled instrument, with the core that other tests also use."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from sim.tests.instrument.sizes import LANES, SAMPLES

from arctrue.cli import main
from arctrue.cli._loaded_set import write_json
from arctrue.instrument import Instrument
from arctrue.studies.scenario import ScenarioResult, read_scenario, run_scenario
from arctrue.studies.scenario.__main__ import results_table
from arctrue.studies.scenario.scenario import REASONS
from arctrue.table import DISC_RADIUS_M

ROOT = Path(__file__).resolve().parents[4]
SCENARIOS = ROOT / "sim" / "scenarios"

COUNT_ARCSEC = 1_296_000 / (64 * 1024)
UM_PER_K = 8.0
WARM_C = (20.0, 22.0, 25.0)
"""Temperatures of the turns. Each temperature is constant for several turns; the table warms in the
pauses between them."""

WARMING = f"""
format = 1
title = "steps of temperature"

[scale]
lines = 64
lanes = {LANES}
samples = {SAMPLES}

[table]
errors = "none"

[motion]
legs = [
    {{ turns = 2.5 }}, {{ pause_s = 900 }}, {{ turns = 2.5 }}, {{ pause_s = 900 }}, {{ turns = 3 }}
]

[[temperature]]
at_turn = 2.5
celsius = {WARM_C[0]}
[[temperature]]
at_turn = 2.5
after_s = 900
celsius = {WARM_C[1]}
[[temperature]]
at_turn = 5
celsius = {WARM_C[1]}
[[temperature]]
at_turn = 5
after_s = 900
celsius = {WARM_C[2]}

[[cause]]
name = "disc_eccentricity"
um = 10
direction_deg = 70
[[cause]]
name = "thermal_centre"
um_per_k = {UM_PER_K}
direction_deg = 70

[firmware]
orders = 8
keep = 0

[[fault]]
what = "hung_processor"
at_turn = 7.2
for_turns = 0.3

[limits]
from_turn = 2
corrected_rms_arcsec = 0.01
refused_turns_most = 0
flags_wanted = ["head1.overspeed"]
flags_allowed = []
"""


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> ScenarioResult:
    file = tmp_path_factory.mktemp("scenario") / "warming.toml"
    file.write_text(WARMING, encoding="utf-8")
    return run_scenario(read_scenario(file))


def test_temperature_of_the_turns(result: ScenarioResult) -> None:
    # The first pause begins in the middle of turn 3.
    assert [turn.temperature_c for turn in result.turns] == pytest.approx(
        [WARM_C[0]] * 3 + [WARM_C[1]] * 2 + [WARM_C[2]] * 3
    )
    assert result.turns[2].events == ("pause of 900 s",)


def test_order_one_follows_the_eccentricity(result: ScenarioResult) -> None:
    """The amplitude of order 1 follows the geometry: a small offset e of the disc changes the angle
    by e/r at the radius r of its lines."""
    for turn in result.turns:
        if turn.number in (3, 5, 6):
            # This turn contains a pause or touches one.
            continue
        metres = (10 + UM_PER_K * (turn.temperature_c - 20.0)) * 1e-6
        expected = np.rad2deg(metres / DISC_RADIUS_M) * 3600
        assert turn.uncorrected is not None
        # Each of the 65,536 edges is rounded to a clock, which is 0.9 count: 0.03″ in an amplitude,
        # and the bound is eight times this.
        assert turn.uncorrected.amplitude_arcsec[0] == pytest.approx(expected, abs=0.25)


def test_the_calibrated_order_one_follows_too(result: ScenarioResult) -> None:
    compared = 0
    for turn in result.turns:
        for reply in turn.telemetry:
            # Telemetry in a turn describes the preceding turn; both turns must have the same
            # temperature.
            if turn.number not in (2, 5, 8) or reply["result"] == "refused":
                continue
            order, amplitude, _, uncertainty, _ = reply["harmonics"][0]
            metres = (10 + UM_PER_K * (turn.temperature_c - 20.0)) * 1e-6
            expected = np.rad2deg(metres / DISC_RADIUS_M) * 3600
            assert order == 1
            # The rounding to counts is not white noise; the test allows a tenth of a count in
            # addition to 4 sigma.
            assert abs(amplitude - expected) < 4 * uncertainty + COUNT_ARCSEC / 10
            compared += 1
    assert compared >= 2


def test_the_correction_acts(result: ScenarioResult) -> None:
    last = result.turns[-1]
    assert last.corrected is not None
    assert last.uncorrected is not None
    assert result.applied >= 3
    # An error uniformly distributed over one count has an RMS of 1/√12 count.
    assert last.corrected.rms_arcsec < 1.2 * COUNT_ARCSEC / np.sqrt(12)
    assert last.uncorrected.rms_arcsec > 100


def test_broken_limits_are_reported(result: ScenarioResult) -> None:
    broken = "\n".join(result.broken)
    assert "turn 8: corrected RMS" in broken
    assert "turn 1:" not in broken
    assert "head1.overspeed was expected, but was not raised" in broken


@pytest.mark.parametrize(
    "limits", ["from_turn = 3\ncorrected_rms_arcsec = 0.01", "applied_turns_least = 9"]
)
def test_command_and_its_exit_code(tmp_path: Path, limits: str) -> None:
    file = tmp_path / "short.toml"
    start, _, _ = WARMING.partition("[motion]")
    text = f"{start}[motion]\nlegs = [{{ turns = 3 }}]\n[limits]\n{limits}\n"
    file.write_text(text, encoding="utf-8")
    written = tmp_path / "out.json"
    done = CliRunner().invoke(
        main, ["run", str(file), "--json", str(written), "--out", str(tmp_path)]
    )
    assert done.exit_code == 1, done.output
    summary = json.loads(written.read_text(encoding="utf-8"))
    assert len(summary["turns"]) == 3
    assert summary["broken"]
    assert "<svg" in (tmp_path / "short.svg").read_text(encoding="utf-8")


def test_a_shipped_scenario_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A shipped scenario runs, with a hung processor and a slow bus at different times."""
    stalls: list[tuple[int, int]] = []
    stall_bus = Instrument.stall_bus

    def noted(instrument: Instrument, most_clocks: int, seed: int = 1) -> None:
        stalls.append((instrument.clock, most_clocks))
        stall_bus(instrument, most_clocks, seed)

    monkeypatch.setattr(Instrument, "stall_bus", noted)
    written = tmp_path / "hung.json"
    file = SCENARIOS / "fault_hung_processor.toml"
    done = CliRunner().invoke(main, ["run", str(file), "--lines", "64", "--json", str(written)])
    assert done.exit_code == 0, done.output
    turns = json.loads(written.read_text(encoding="utf-8"))["turns"]
    # The processor hangs from turn 3.3 to 5.3: it reports nothing in the complete turn between
    # these, which is row five.
    assert [bool(turn["telemetry"]) for turn in turns] == [False, *[True] * 3, False, *[True] * 3]
    (after,) = turns[5]["telemetry"]
    assert "overrun" in after["alarms"]
    assert [most for _, most in stalls] == [20, 0]
    # The bus is slow for two turns at 30°/s; the firmware may still have been reading a capture at
    # the old bus speed.
    scenario = read_scenario(file, lines=64)
    turn_clocks = 12 * scenario.clock_hz
    assert stalls[1][0] - stalls[0][0] == pytest.approx(2 * turn_clocks, abs=0.5 * turn_clocks)


@pytest.mark.large
def test_a_dead_head(tmp_path: Path) -> None:
    written = tmp_path / "dead.json"
    file = SCENARIOS / "fault_dead_head2.toml"
    CliRunner().invoke(main, ["run", str(file), "--lines", "64", "--json", str(written)])
    summary = json.loads(written.read_text(encoding="utf-8"))
    assert summary["refused"] >= 1
    for turn in summary["turns"]:
        # Head 2 is dead from turn 3.2 on and reads correctly before; head 1 always reads correctly.
        wrong = [flag for flag in turn["flags"] if flag.startswith("head2")]
        assert bool(wrong) <= (turn["turn"] >= 4)
        assert not [flag for flag in turn["flags"] if flag.startswith("head1")]
    assert any(turn["flags"] for turn in summary["turns"])
    # The corrected output continues while head 2 is dead.
    assert summary["turns"][4]["corrected"]["rms_arcsec"] < 10


def test_bad_file_ends_with_two(tmp_path: Path) -> None:
    file = tmp_path / "bad.toml"
    file.write_text("format = 1\n", encoding="utf-8")
    done = CliRunner().invoke(main, ["run", str(file)])
    assert done.exit_code == 2
    assert str(file) in done.output
    assert "Traceback" not in done.output


def test_a_table_that_is_too_fast_is_reported(tmp_path: Path) -> None:
    """The command reports a table that is too fast: a vibration of 3600″ at 500 Hz moves it by up
    to 1,900″, or a hundred counts, in one clock of 6 kHz."""
    file = tmp_path / "fast.toml"
    start, _, _ = WARMING.partition("[motion]")
    effect = '[[cause]]\nname = "bracket_vibration"\nhead = 1\narcsec = 3600\nhz = 500\n'
    file.write_text(f"{start}[motion]\nlegs = [{{ turns = 1 }}]\n{effect}", encoding="utf-8")
    done = CliRunner().invoke(main, ["run", str(file)])
    assert done.exit_code == 2
    assert "count" in done.output
    assert "Traceback" not in done.output


def test_reasons_are_those_of_the_firmware() -> None:
    source = (ROOT / "firmware" / "calibration" / "refusal.c").read_text(encoding="utf-8")
    assert re.findall(r'\] = "(\w+)"', source)[1:] == list(REASONS)


def test_table_of_written_results(tmp_path: Path, result: ScenarioResult) -> None:
    file = tmp_path / "warming.json"
    write_json(file, result.as_json())
    *_, line = results_table([file]).splitlines()
    cells = [cell.strip() for cell in line.strip("|").split("|")]
    last = result.turns[-1]
    assert last.uncorrected is not None
    assert cells[:4] == ["`warming`", "8", str(result.applied), str(result.refused)]
    assert cells[4] == f"{last.uncorrected.rms_arcsec:.2f}″"
    assert cells[-1] == ""
