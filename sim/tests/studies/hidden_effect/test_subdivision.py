"""Test of the demo's second act at a small scale: the set shows the effect, and the corrected
output no longer contains it."""

from __future__ import annotations

import dataclasses
import json
import re
from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from click.testing import CliRunner
from sim.tests.studies.hidden_effect.small import LINES, small_settings

from arctrue.cli import demo as command
from arctrue.cli import main
from arctrue.gateware.coefficient_file import read_coefficient_file
from arctrue.instrument import InstrumentError
from arctrue.measurement import read_measurement_set
from arctrue.report.second_act_page import write_second_act_page
from arctrue.studies.demo.second_act import SecondAct, faults, run_second_act
from arctrue.studies.hidden_effect.result import HiddenResult
from arctrue.studies.simulate.truth import read_truth
from arctrue.table import TableState

ARCSEC_A_RADIAN = 648_000 / np.pi
# To first order (Heydemann), the offsets of head 1's SignalDistortion cause an error once per
# signal period; half the gain difference and half the phase error cause an error twice per period.
# The values are shares of a radian of the signal period.
ONCE_ARCSEC = np.hypot(0.036, 0.035) / LINES * ARCSEC_A_RADIAN
TWICE_ARCSEC = 0.5 * np.hypot(0.016, 0.012) / LINES * ARCSEC_A_RADIAN
COUNT_ARCSEC = 1_296_000 / (LINES * 256)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("subdivision")


@pytest.fixture(scope="module")
def act(folder: Path) -> SecondAct:
    return run_second_act(small_settings(), folder, lambda _: None)


@pytest.fixture
def result(act: SecondAct) -> Iterator[HiddenResult]:
    return act.result


def test_the_workbench_names_it_and_sees_nothing_else(result: HiddenResult) -> None:
    assert result.diagnosed.diagnosis.verdict == "named"
    assert result.diagnosed.effect == "subdivision_error"
    files = {path.name for path in result.folder.iterdir()}
    assert files == {"measurement.toml", "capture.csv", "reference.csv"}
    assert read_truth(result.folder)["hidden"] == "subdivision_error"
    description = (result.folder / "measurement.toml").read_text()
    assert not re.search("subdivision|hidden|distort", description, re.IGNORECASE)


def test_its_size_is_that_of_the_signals(result: HiddenResult) -> None:
    found = result.diagnosed.model.effects[-1].parameters
    once, twice = found["head1_multiple_1_amplitude"], found["head1_multiple_2_amplitude"]
    # The tolerance covers the square of the distortion, its second order, which is a twentieth.
    assert once.value == pytest.approx(ONCE_ARCSEC, abs=4 * once.sigma + 0.05 * ONCE_ARCSEC)
    assert twice.value == pytest.approx(TWICE_ARCSEC, abs=4 * twice.sigma + 0.05 * ONCE_ARCSEC)


def test_capture_and_reference_are_those_of_the_gateware(result: HiddenResult) -> None:
    measured = read_measurement_set(result.folder)
    capture, reference = measured.capture, measured.reference
    assert capture is not None
    assert reference is not None
    samples = result.settings.revolution.samples
    # The run has two turns. The first turn includes its closing sample, and a turn may be one
    # sample longer.
    assert 2 * samples - 60 < capture.run.size < 2 * samples + 60
    # The table's geometry gives the expected error of these turns; the constant of each turn is
    # unknown.
    table = result.settings.table(result.case.build(result.settings))
    turn = np.linspace(-0.7, 5 * np.pi, 1 << 19)
    head1, head2 = (table.reading_rad(head, TableState.at_rest(turn)) for head in (0, 1))
    stations = np.deg2rad(reference.target_deg)
    error = np.interp(stations, turn, head1 - turn) * ARCSEC_A_RADIAN
    off = reference.error_arcsec - error
    # The readings are whole counts, the edges come in whole clocks (1.14 per count), and each of
    # the two readings has 0.1″ of noise.
    whole = COUNT_ARCSEC / np.sqrt(12)
    assert 0.9 * whole < np.std(off) < np.hypot(whole, whole / 1.14) + 0.2
    count_rad = table.count_rad
    apart = np.interp((capture.head1_counts + 0.5) * count_rad, head1, head2 - head1)
    seen = (capture.head2_counts - capture.head1_counts) * count_rad
    assert np.std(seen - apart) * ARCSEC_A_RADIAN < 1.15 * COUNT_ARCSEC / np.sqrt(6)
    # The readings of the reference run have the phase of the grating, because they are counted from
    # the index of head 1.
    assert reference.head1_counts is not None
    stands = np.interp(stations, turn, head1) / count_rad
    turns = np.round((reference.head1_counts - stands) / table.counts_per_rev)
    late = reference.head1_counts - stands - turns * table.counts_per_rev
    # A reading is rounded down to its count (0.5 on average). The zero of the reading is the edge
    # of Z between two recorded edges, which is known to one count, like an index mark. Edges come
    # in whole clocks, half a clock late on average.
    assert abs(np.mean(late) + 0.5) < 1.0 + 0.5 / 1.14


def test_new_lanes_stand_at_the_signal_period(result: HiddenResult, folder: Path) -> None:
    written = read_coefficient_file(folder / "coefficients.toml")
    assert written == result.export.coefficients
    assert set(written.orders.tolist()) == {1, 2, LINES, 2 * LINES}


def test_the_output_of_the_gateware_gets_better(result: HiddenResult) -> None:
    raw, paper, corrected = result.raw, result.paper, result.corrected
    periods = (result.raw_period, result.paper_period, result.corrected_period)
    raw_signal, paper_signal, corrected_signal = (item.amplitude_arcsec[0] for item in periods)
    assert raw_signal == pytest.approx(ONCE_ARCSEC, rel=0.05)
    # The paper's model removes the error of the disc and leaves the error of the signal period
    # unchanged.
    assert paper.amplitude_arcsec[0] < 0.01 * raw.amplitude_arcsec[0]
    assert paper_signal == pytest.approx(raw_signal, rel=0.05)
    assert corrected_signal < 0.1 * paper_signal
    assert corrected.edges_rms_arcsec < 0.5 * paper.edges_rms_arcsec
    # Two parts remain in the output: the rounding of input and output to whole counts, 1.4″ RMS
    # each, and the orders that are not corrected, about 1.1″ RMS.
    whole = COUNT_ARCSEC / np.sqrt(12)
    assert corrected.edges_rms_arcsec == pytest.approx(np.hypot(whole * np.sqrt(2), 1.1), rel=0.25)


def test_the_fresh_capture_agrees_without_a_fit(result: HiddenResult) -> None:
    without, with_it = (result.fresh_capture_arcsec[key] for key in ("without", "with"))
    # The difference contains the readings of two heads, each in whole counts.
    assert with_it == pytest.approx(COUNT_ARCSEC / np.sqrt(6), rel=0.1)
    assert without > 4 * with_it


def test_the_ladder_has_the_paper_s_step_and_the_effect_s(result: HiddenResult) -> None:
    steps = result.diagnosed.ladder
    assert [step.effect for step in steps] == ["graduation_harmonics", "subdivision_error"]
    assert all(
        steps[1].heldout_rms_arcsec[channel] < 0.3 * steps[0].heldout_rms_arcsec[channel]
        for channel in ("capture", "reference")
    )


def test_judgement_passes_it_and_fails_what_is_wrong(act: SecondAct, result: HiddenResult) -> None:
    assert act.passed
    assert any(
        "signal period" in text
        for text in faults(dataclasses.replace(result, corrected_period=result.paper_period))
    )
    no_better = faults(dataclasses.replace(result, corrected=result.paper))
    assert any("RMS of the output" in text for text in no_better)
    other = dataclasses.replace(result.diagnosed, effect="vibration")
    assert any("vibration" in text for text in faults(dataclasses.replace(result, diagnosed=other)))


def test_page_and_json(act: SecondAct, folder: Path, tmp_path: Path) -> None:
    write_second_act_page(act, tmp_path / "second_act.html")
    page = (tmp_path / "second_act.html").read_text(encoding="utf-8")
    pictures = re.findall(r"<svg.*?</svg>", page, re.DOTALL)
    assert len(pictures) == 3
    for picture in pictures:
        ElementTree.fromstring(picture)
    assert not re.search(r'(?:src|href)="(?!#|data:)', page)
    within = ("Within the limits", "subdivision_error", "held out", "262,144 counts")
    for words in (*within, "Effects that the device can correct"):
        assert words in page
    failed = dataclasses.replace(act, faults=("it is <worse>",))
    write_second_act_page(failed, tmp_path / "bad.html")
    assert "it is &lt;worse&gt;" in (tmp_path / "bad.html").read_text(encoding="utf-8")
    text = (folder / "result.json").read_text(encoding="utf-8")
    stored = json.loads(text, parse_constant=pytest.fail)  # NaN and Infinity are not JSON
    assert stored["added"] == "subdivision_error"
    assert stored["corrected"]["rms_arcsec"] == act.result.corrected.rms_arcsec


def test_command_runs_the_second_act_alone(
    monkeypatch: pytest.MonkeyPatch, act: SecondAct, tmp_path: Path
) -> None:
    monkeypatch.setattr(command, "run_second_act", lambda *_: act)
    answer = CliRunner().invoke(main, ["demo", "--out", str(tmp_path), "--act", "2"])
    assert answer.exit_code == 0, answer.output
    assert "Within the limits" in answer.output
    assert (tmp_path / "second_act.html").exists()
    assert not (tmp_path / "index.html").exists()

    def broken(*_: object) -> SecondAct:
        raise InstrumentError("no Verilator here")

    monkeypatch.setattr(command, "run_second_act", broken)
    answer = CliRunner().invoke(main, ["demo", "--out", str(tmp_path), "--act", "2"])
    assert answer.exit_code == 2
    assert "no Verilator here" in answer.output


@pytest.mark.large
def test_a_wrong_output_ends_with_1(
    monkeypatch: pytest.MonkeyPatch, act: SecondAct, tmp_path: Path
) -> None:
    wrong = dataclasses.replace(act, faults=("worse than before",))
    monkeypatch.setattr(command, "run_second_act", lambda *_: wrong)
    answer = CliRunner().invoke(main, ["demo", "--out", str(tmp_path), "--act", "2"])
    assert answer.exit_code == 1
    assert "second act: worse than before" in answer.output
