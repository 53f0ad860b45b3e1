"""Tests that the rival methods, with which the benchmark compares the diagnosis, find the causes
that they can show, and name no cause in sets without one."""

from __future__ import annotations

import sys
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from click.testing import CliRunner
from sim.tests.studies.campaign.loaded import loaded_by

from arctrue.cli import main
from arctrue.measurement import write_measurement_set
from arctrue.report.benchmark_page import PEERS_STATED, benchmark_page
from arctrue.studies.benchmark.answers import AnswersError, Verdict, score_of_peers
from arctrue.studies.benchmark.digests import set_name
from arctrue.studies.benchmark.frozen import frozen_digests
from arctrue.studies.benchmark.peers.periodogram_rule import _chance
from arctrue.studies.benchmark.peers.stepwise_bic import _gains
from arctrue.studies.benchmark.peers.textbook import Fit, problem, waves
from arctrue.studies.benchmark.plan import TierPlan, make_plan, read_plan, sources_of
from arctrue.studies.benchmark.subject import SUBJECTS, find_subject
from arctrue.studies.campaign.code_state import import_closure
from arctrue.studies.campaign.store import Store
from arctrue.studies.simulate.experiment import full, lean
from arctrue.studies.simulate.simulated_set import Wanted, simulate_set

PEERS = [name for name in SUBJECTS if name != "arctrue"]


def written(tmp_path: Path, *wanted: Wanted, seed: int = 4) -> Path:
    folder = tmp_path / "set"
    write_measurement_set(folder, simulate_set(wanted, full().smaller(1500, 5), seed).measurement)
    return folder


@pytest.mark.parametrize("subject", PEERS)
def test_nothing_is_adequate(tmp_path: Path, subject: str) -> None:
    assert find_subject(subject)(written(tmp_path))["verdict"] == "adequate"


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("hysteresis", 3.0),
        pytest.param("head_angle_error", 20.0, marks=pytest.mark.large),
        pytest.param("latency", 50.0, marks=pytest.mark.large),
    ],
)
def test_stepwise_names_a_strong_effect(tmp_path: Path, name: str, size: float) -> None:
    found = find_subject("stepwise_bic")(written(tmp_path, Wanted(name, size)))
    assert (found["named"], found["further"]) == (name, [])


@pytest.mark.parametrize("subject", PEERS)
def test_few_rows_a_turn_get_an_answer(tmp_path: Path, subject: str) -> None:
    """The sets have half a row for each order that a rival method searches, or a run of one row."""
    folder = written(tmp_path)
    heading, *rows = (folder / "capture.csv").read_text(encoding="utf-8").splitlines()
    first = ",".join(["99", *rows[0].split(",")[1:]])
    assert heading.startswith("run,")
    thin = "\n".join([heading, first, *rows[60::60], ""])
    (folder / "capture.csv").write_text(thin, encoding="utf-8")
    assert find_subject(subject)(folder)["verdict"] in get_args(Verdict)


def test_the_chance_of_two_very_strong_lines_follows_their_power() -> None:
    values = np.tile([1.0, -1.0], 50)
    assert _chance(900.0, values, 10) < _chance(800.0, values, 10) < _chance(20.0, values, 10)
    assert _chance(30.0001, values, 10) == pytest.approx(_chance(29.9999, values, 10), rel=1e-4)


def test_periodogram_names_a_line_in_time(tmp_path: Path) -> None:
    found = find_subject("periodogram_rule")(written(tmp_path, Wanted("vibration", 1.0), seed=5))
    assert found["named"] == "vibration"


@pytest.mark.parametrize("hidden", [("thermal_eccentricity", 0.9), ("reference_drift", 3.0)])
def test_gaussian_process_sees_a_discrepancy_and_has_no_name_for_it(
    tmp_path: Path, hidden: tuple[str, float]
) -> None:
    found = find_subject("gaussian_process")(written(tmp_path, Wanted(*hidden)))
    assert (found["verdict"], found["named"]) == ("unknown", None)


@pytest.mark.parametrize("subject", PEERS)
def test_a_lean_set_is_answered_too(tmp_path: Path, subject: str) -> None:
    folder = tmp_path / "set"
    write_measurement_set(folder, simulate_set([], lean().smaller(600, 0), 4).measurement)
    assert find_subject(subject)(folder)["verdict"] in get_args(Verdict)


def test_an_index_that_does_not_repeat_is_no_effect(tmp_path: Path) -> None:
    # The model of the rival methods has an offset for each run; the stated repeatability of the
    # index, one count, limits the size of this offset.
    folder = tmp_path / "set"
    made = simulate_set([], full().smaller(1500, 5), 4, index_scatter_counts=1)
    write_measurement_set(folder, made.measurement)
    assert find_subject("stepwise_bic")(folder)["verdict"] == "adequate"


def test_gain_of_a_place_is_that_of_a_fit_of_all_columns(tmp_path: Path) -> None:
    fit = Fit(problem(written(tmp_path, Wanted("vibration", 1.0))))
    columns = fit.whole(fit.given.on_disc(np.array([33, 34])))
    gains, ranks = _gains(fit, columns, fit.scaled_left)
    scaled = fit.data / fit.scale
    for place in (0, 1):
        both = np.hstack([fit.basis, columns[:, place, :]])
        left = scaled - both @ np.linalg.lstsq(both, scaled)[0]
        fall = float(fit.scaled_left @ fit.scaled_left - left @ left)
        assert gains[place] == pytest.approx(fall, rel=1e-6)
    assert ranks.tolist() == [2, 2]


def test_waves_by_multiplication_are_those_of_cosine_and_sine() -> None:
    angle, orders = np.linspace(-9.0, 30.0, 50), np.arange(21, 53)
    phase = np.multiply.outer(angle, orders)
    expected = np.stack([np.cos(phase), np.sin(phase)], axis=2)
    # The bound covers 32 multiplications, and orders · angle of up to 1,600 rad, in float64.
    np.testing.assert_allclose(waves(angle, orders), expected, atol=1e-12)


def test_peers_are_scored_over_the_sets_that_all_have(tmp_path: Path) -> None:
    plan = make_plan("quick", tmp_path)
    truth = {"effects": [], "noise": [], "adverse_conditions": [], "floor_arcsec": {}}
    said = {"arctrue": ("adequate", 3), "stepwise_bic": ("named", 2)}
    with pytest.raises(AnswersError, match="no subject has answered"):
        score_of_peers(tmp_path)
    for name, (verdict, number) in said.items():
        with Store(tmp_path / name, header_of(plan, name)) as store:
            for task in plan.tasks(name)[:number]:
                answer = {"verdict": verdict, "named": "vibration"}
                store.add(task, {"truth": truth, "answer": answer}, 1.0)
    found = score_of_peers(tmp_path)
    rates = {name: scores["rates"]["false name"]["all"] for name, scores in found.items()}
    assert [(rate["hits"], rate["of"]) for rate in rates.values()] == [(0, 2), (2, 2)]
    text = benchmark_page(header_of(plan, "arctrue"), found["arctrue"], found)
    assert "The same 2 of the 65 sets of the tier *quick*: 0 with something" in text
    assert "Commit `of step`, source `step`" in text
    assert "another state of the code" not in text
    assert "| false name | 0.0 (0.0 … 84.2) of 2 | 100.0 (15.8 … 100.0) of 2 |" in text


def test_command_writes_the_page_and_the_picture_that_it_shows(tmp_path: Path) -> None:
    run, place = tmp_path / "run", tmp_path / "docs"
    answered(run, "arctrue", header_of(make_plan("quick", run), "arctrue"))
    place.mkdir()
    words = ["benchmark", "page", str(run), "--to", str(place / "benchmark.md")]
    for more, shown in ([], False), (["--out", str(place / "images")], True):
        done = CliRunner().invoke(main, [*words, *more])
        assert done.exit_code == 0, done.output
        text = (place / "benchmark.md").read_text(encoding="utf-8")
        assert ("](images/benchmark.svg)" in text) is shown
        assert (place / "images" / "benchmark.svg").is_file() is shown


def header_of(plan: TierPlan, subject: str, **code: str) -> dict[str, Any]:
    libraries = {"numpy": "2", "scipy": "1", "pyarrow": "9"}
    return {
        "plan": asdict(plan),
        "subject": subject,
        "code": {"arctrue": subject[:4], **libraries, **code},
        "commit": f"of {subject[:4]}",
    }


def answered(folder: Path, subject: str, header: dict[str, Any], number: int = 2) -> None:
    truth = {"effects": [], "noise": [], "adverse_conditions": [], "floor_arcsec": {}}
    with Store(folder / subject, header) as store:
        for task in read_plan(folder).tasks(subject)[:number]:
            store.add(task, {"truth": truth, "answer": {"verdict": "adequate"}}, 1.0)


def test_rivals_without_a_set_in_common_are_not_set_with_each_other(tmp_path: Path) -> None:
    plan = make_plan("quick", tmp_path)
    answered(tmp_path, "arctrue", header_of(plan, "arctrue"))
    answered(tmp_path, "stepwise_bic", header_of(plan, "stepwise_bic"), number=0)
    with pytest.raises(AnswersError, match="no set yet that arctrue, stepwise_bic have answered"):
        score_of_peers(tmp_path)


def test_answers_with_other_libraries_are_not_set_with_each_other(tmp_path: Path) -> None:
    plan = make_plan("quick", tmp_path)
    answered(tmp_path, "arctrue", header_of(plan, "arctrue"))
    answered(tmp_path, "gaussian_process", header_of(plan, "gaussian_process", numpy="1"))
    with pytest.raises(AnswersError, match=r"gaussian_process with .*two states are not mixed"):
        score_of_peers(tmp_path)


def test_answers_to_other_sets_are_not_set_with_each_other(tmp_path: Path) -> None:
    plan = make_plan("quick", tmp_path)
    answered(tmp_path, "arctrue", header_of(plan, "arctrue"))
    answered(tmp_path, "stepwise_bic", header_of(replace(plan, generator="0"), "stepwise_bic"))
    with pytest.raises(AnswersError, match="stepwise_bic has answers to the sets of another plan"):
        score_of_peers(tmp_path)


def test_answers_to_public_sets_are_those_to_the_frozen_ones(tmp_path: Path) -> None:
    plan = make_plan("public", tmp_path)
    task = plan.tasks("stepwise_bic")[0]
    truth = {"effects": [], "noise": [], "adverse_conditions": [], "floor_arcsec": {}}
    for digest, right in ((frozen_digests()[set_name(task)], True), ("0" * 16, False)):
        subject = "stepwise_bic" if right else "periodogram_rule"
        with Store(tmp_path / subject, header_of(plan, subject)) as store:
            result = {"truth": truth, "set": digest, "answer": {"verdict": "adequate"}}
            store.add(plan.tasks(subject)[0], result, 1.0)
        if right:
            assert score_of_peers(tmp_path)[subject]["sets"] == 1
    with pytest.raises(AnswersError, match=r"periodogram_rule: 1 of 1 answers are to other sets"):
        score_of_peers(tmp_path)


def test_public_sets_that_differ_are_not_answered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make_plan("public", tmp_path)
    monkeypatch.setattr("arctrue.studies.benchmark.frozen.frozen_digests", dict)
    done = CliRunner().invoke(main, ["benchmark", "run", str(tmp_path), "--subject=stepwise_bic"])
    assert done.exit_code == 2
    assert "first public set made here differs from the frozen one" in done.output


def test_page_says_that_its_own_column_is_of_another_state(tmp_path: Path) -> None:
    plan = make_plan("quick", tmp_path)
    answered(tmp_path, "arctrue", header_of(plan, "arctrue", arctrue="old"))
    further = score_of_peers(tmp_path)
    text = benchmark_page(header_of(plan, "arctrue"), further["arctrue"], further)
    assert "answers of `arctrue` in this table are of another state of the code" in text


@pytest.mark.large
def test_answers_of_a_rival_do_not_depend_on_the_diagnosis_and_ours_do() -> None:
    for name in PEERS:
        loaded = loaded_by(SUBJECTS[name].module)
        assert not any({"workbench", "table"} & set(file.parts) for file in loaded)
        assert loaded <= set(import_closure(sources_of(name).modules)), name
    assert sources_of("arctrue").modules == ()


def test_every_subject_is_reported_on_the_page() -> None:
    assert set(PEERS_STATED) == set(SUBJECTS)


def test_a_subject_without_its_library_is_an_error_for_people(monkeypatch) -> None:  # type: ignore[no-untyped-def]
    module = "arctrue.studies.benchmark.peers.gaussian_process"
    monkeypatch.delitem(sys.modules, module, raising=False)
    monkeypatch.setitem(sys.modules, "sklearn.exceptions", None)
    with pytest.raises(ValueError, match=r"pip install 'arctrue\[studies\]'"):
        find_subject("gaussian_process")
