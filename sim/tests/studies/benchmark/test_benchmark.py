"""Tests of the benchmark's plans, seals, outcomes, rates, answers and commands."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from arctrue.cli import main
from arctrue.measurement import read_measurement_set
from arctrue.report.benchmark_page import MOST_FAILURES, benchmark_page
from arctrue.report.benchmark_sets_page import INDEPENDENCE
from arctrue.studies.benchmark import plan as plan_module
from arctrue.studies.benchmark.answers import AnswersError, score_folders
from arctrue.studies.benchmark.cases import (
    Reason,
    case_tasks,
    keep,
    kept_cases,
    kept_reasons,
)
from arctrue.studies.benchmark.diagnosis import answer_of
from arctrue.studies.benchmark.digests import set_name
from arctrue.studies.benchmark.frozen import FILE as FROZEN
from arctrue.studies.benchmark.frozen import differing, freeze, frozen_digests, task_digest
from arctrue.studies.benchmark.independent.world import HIDDEN, independent_worlds
from arctrue.studies.benchmark.intervals import (
    Rate,
    calibration_error,
    expected_calibration_error,
    log_score_gain,
    rate,
    reliability,
)
from arctrue.studies.benchmark.outcome import GOOD, OUTCOMES, Judged
from arctrue.studies.benchmark.perfect import perfect_calibration
from arctrue.studies.benchmark.plan import (
    CASES,
    SCORING,
    TIERS,
    PlanError,
    files_digest,
    make_plan,
    read_plan,
)
from arctrue.studies.benchmark.score import SCORES, by_effect, scored
from arctrue.studies.benchmark.sets import make_set
from arctrue.studies.benchmark.work import run_set
from arctrue.studies.benchmark.worlds import (
    CATALOGUE,
    CONTENTS,
    FOUR_HEADS,
    HEADS_SHOW,
    PARTS,
    WORLDS,
    hidden,
)
from arctrue.studies.campaign import task_key
from arctrue.studies.campaign.store import Store


def effect(name: str, kind: str = "catalogue", limits: float = 3.0) -> dict[str, Any]:
    return {
        "effect": name,
        "kind": kind,
        "parts": ["order:2", "disc"] if kind == "parts" else [],
        "size": 1.0,
        "unit": "um",
        "noncentrality": 20.0 * limits**2,
        "needed": 20.0,
        "rms_arcsec": 0.1,
    }


def header_of(sets: int) -> dict[str, Any]:
    plan = {"tier": "dev", "seed": 2, "sets": sets, "generator": "g", "scoring": "s"}
    code = {"arctrue": "a", "numpy": "2"}
    return {"plan": plan, "code": code, "commit": "1234567890", "subject": "arctrue"}


def judged(
    verdict: str, *effects: dict[str, Any], named: str | None = None, **answer: Any
) -> Judged:
    task = {"world": "white", "content": "one", "seed": 5, "samples": 1500, "subject": "x"}
    truth = {
        "effects": list(effects),
        "noise": [],
        "adverse_conditions": [],
        "floor_arcsec": {"capture": 0.1},
    }
    return Judged(task, truth, {"verdict": verdict, "named": named, **answer})


@pytest.mark.parametrize(
    ("item", "expected"),
    [
        (judged("named", effect("latency"), named="latency"), "right"),
        (judged("named", effect("latency"), effect("vibration"), named="vibration"), "right"),
        (judged("named", effect("latency"), named="vibration"), "false name"),
        (judged("named", named="vibration"), "false name"),
        (judged("named", effect("flat_track", "stranger"), named="vibration"), "false name"),
        (judged("ambiguous", effect("latency"), **{"class": ["latency", "x"]}), "first in class"),
        (judged("ambiguous", effect("latency"), **{"class": ["x", "latency"]}), "in class"),
        (judged("ambiguous", effect("latency"), **{"class": ["x"]}), "class without it"),
        (judged("unknown", effect("flat_track", "stranger")), "unknown, rightly"),
        (judged("unknown", effect("latency")), "unknown, wrongly"),
        (judged("adequate", effect("latency")), "falsely adequate"),
        (judged("adequate", effect("latency", limits=0.9)), "adequate, rightly"),
        (judged("adequate"), "adequate, rightly"),
        (judged("cannot_tell", effect("latency")), "silent"),
        (judged("cannot_tell"), "cannot tell, rightly"),
        (judged("bad_data"), "bad data"),
        (judged("error"), "error"),
    ],
)
def test_outcomes(item: Judged, expected: str) -> None:
    assert item.outcome == expected
    assert expected in OUTCOMES


def test_what_does_not_matter_is_not_visible() -> None:
    small = {**effect("latency"), "rms_arcsec": 0.038}
    assert judged("adequate", small).outcome == "adequate, rightly"
    assert judged("adequate", {**small, "rms_arcsec": 0.039}).outcome == "falsely adequate"


def test_a_second_name_that_is_there_is_none_too_many() -> None:
    pair = (effect("latency"), effect("vibration"))
    assert judged("named", *pair, named="latency", further=["vibration"]).second_name is None
    one = judged("named", pair[0], named="latency", further=["vibration"])
    assert one.second_name == "vibration"


def test_intervals_are_the_published_ones() -> None:
    # The two-sided interval of 0 in 100 is 0 … 3.62 %; that of 5 in 50 is 3.33 … 21.81 % (Clopper
    # and Pearson).
    assert Rate(0, 100).interval == pytest.approx((0.0, 0.03622), abs=1e-5)
    assert Rate(5, 50).interval == pytest.approx((0.03328, 0.21813), abs=1e-5)
    assert Rate(0, 0).interval == (0.0, 1.0)
    assert str(Rate(0, 0)) == "no such set"


def test_calibration_error_of_a_known_curve() -> None:
    """The calibration error of a known curve equals the value calculated by hand: ten bins of three
    answers each have one right answer; the stated probability is 1/3 in nine bins and 0.9 in the
    tenth."""
    stated = [1 / 3] * 27 + [0.9] * 3
    right = [True, False, False] * 10
    bins = reliability(stated, right)
    assert [(item.mean_probability, item.right) for item in bins] == [
        *[(pytest.approx(1 / 3), Rate(1, 3))] * 9,
        (pytest.approx(0.9), Rate(1, 3)),
    ]
    assert expected_calibration_error(bins) == pytest.approx((0.9 - 1 / 3) / 10)
    # The order of the answers does not matter.
    assert reliability(stated[::-1], right[::-1])[-1] == bins[-1]
    assert expected_calibration_error(reliability([1.0], [True])) == 0.0
    assert len(reliability([0.5] * 4, [True] * 4)) == 4
    found = calibration_error(stated, right)
    assert found.value == pytest.approx((0.9 - 1 / 3) / 10)
    # A resample distributes the right answers unevenly over the bins, which nearly always increases
    # such a small calibration error.
    assert 0.0 < found.low < found.high < 0.5


def test_log_score_is_compared_with_the_best_constant() -> None:
    """Four right answers at 0.8 and one wrong answer at 0.3 are compared with the constant 0.8; the
    expected gain is calculated by hand."""
    found = log_score_gain([0.8] * 4 + [0.3], [True] * 4 + [False])
    own = (4 * np.log(0.8) + np.log(0.7)) / 5
    constant = (4 * np.log(0.8) + np.log(0.2)) / 5
    assert found.value == pytest.approx(own - constant)
    assert log_score_gain([0.6, 0.6], [True, False]).value < 0
    # An answer that is certain and wrong loses at most log(0.001).
    assert log_score_gain([1.0, 1.0], [True, False]).value == pytest.approx(
        (np.log(0.999) + np.log(0.001)) / 2 + np.log(2)
    )


def test_a_perfect_calibration_has_an_error_by_chance() -> None:
    """1,000 answers with p = 0.9: the share of right ones among the 100 of a bin has σ = √(p(1 −
    p)/100) = 0.03, and its mean distance from p is σ·√(2/π) = 0.0239 (normal limit). The mean of
    ten such distances scatters by 0.03·√(1 − 2/π)/√10 = 0.0057, so that 5 % are above 0.033."""
    mean, most = perfect_calibration([0.9] * 1000)
    assert mean == pytest.approx(0.03 * np.sqrt(2.0 / np.pi), rel=0.03)
    assert most == pytest.approx(0.0239 + 1.645 * 0.0057, rel=0.05)
    assert perfect_calibration([1.0] * 50) == (0.0, 0.0)


def test_interval_of_a_bootstrap_falls_with_the_root_of_the_number() -> None:
    """The width of a bootstrap interval falls as 1/√n, because apart from the constant the gain is
    a mean over the sets."""
    random = np.random.default_rng(1)
    widths = []
    for number in (100, 1600):
        right = (random.random(number) < 0.5).tolist()
        found = log_score_gain(random.uniform(0.2, 0.8, number).tolist(), right)
        widths.append(found.high - found.low)
    assert widths[0] / widths[1] == pytest.approx(4.0, rel=0.25)


def test_probabilities_are_scored_where_they_are_stated_and_left_out_where_not() -> None:
    stated = {"latency": 0.7, "vibration": 0.2, "none": 0.06, "unknown": 0.04}
    pair = (effect("latency"), effect("vibration"))
    two = judged("named", *pair, named="latency", probability=stated)
    assert two.probability_of_truth() == pytest.approx(0.9)
    assert (
        judged("unknown", effect("x", "parts"), probability=stated).probability_of_truth() == 0.04
    )
    assert judged("adequate", probability=stated).probability_of_truth() == 0.06
    assert judged("named", pair[0], named="latency").probability_of_truth() is None
    found = scored([two, judged("named", pair[0], named="vibration", probability=stated)])
    assert found["probability"]["mean_of_truth_where_visible"] == pytest.approx(0.8)
    assert found["probability"]["calibration_error"]["value"] == pytest.approx(0.3)
    assert (found["probability"]["right_of"]["name"]["hits"], two.first_kind()) == (2, "name")
    assert found["probability"]["right_of"]["unknown"]["of"] == 0
    assert scored([judged("adequate")])["probability"] is None


def test_sure_answers_are_counted_by_what_they_say() -> None:
    """Only answers with a probability above 0.8 count as sure; the answer to the third set states
    0.7."""
    latency = effect("latency")
    sure, unsure = {"latency": 0.9, "unknown": 0.1}, {"latency": 0.7, "unknown": 0.3}
    sets = [
        judged("named", latency, named="latency", probability=sure),
        judged("named", effect("vibration"), named="latency", probability=sure),
        judged("named", latency, named="latency", probability=unsure),
        judged("unknown", effect("x", "stranger"), probability={"unknown": 0.9, "none": 0.1}),
        judged("adequate"),
    ]
    wrong = scored(sets)["probability"]["wrong_where_sure"]
    assert {kind: (rate["hits"], rate["of"]) for kind, rate in wrong.items()} == {
        "name": (1, 2),
        "unknown": (0, 1),
        "none": (0, 0),
    }


def test_rates_count_what_they_say() -> None:
    sets = [
        judged("named", effect("latency"), named="latency", further=["vibration"]),
        judged("named", effect("latency"), named="vibration"),
        judged("adequate", effect("latency")),
        judged("adequate"),
        judged("unknown", effect("flat_track", "stranger")),
        judged("unknown", effect("warm_ovality", "parts"), parts=["disc", "order:2"]),
        judged("cannot_tell", effect("flat_track", "stranger")),
    ]
    found = {score.name: (score.of(sets).hits, score.of(sets).of) for score in SCORES}
    assert found["false name"] == (1, 7)
    assert found["false name or falsely adequate"] == (2, 7)
    assert found["right first, of what the oracle sees of the catalogue"] == (1, 3)
    assert found["unknown, of visible strangers"] == (1, 2)
    assert found["unknown with the right parts, of the same"] == (1, 1)
    assert found["a second name that is not there, of right names"] == (1, 1)
    assert found["silent where the oracle sees (cannot tell, bad data, error)"] == (1, 6)
    whole = scored(sets)
    assert len(whole["failures"]) == 4
    assert whole["confusion"]["latency"] == {"latency": 1, "vibration": 1, "adequate": 1}
    page_text = "--world white --content one --seed 5 --samples 1500"
    assert all(page_text in item["command"] for item in whole["failures"])
    text = benchmark_page(header_of(sets=9), whole)
    assert "**7 of its 9 sets** (the run was not finished)" in text
    assert "Commit `1234567890`, source `a`" in text
    assert f"scored by `{files_digest(SCORING)}`; numpy 2." in text
    assert "| false name | ≤ 1 | **14.3 (0.4 … 57.9) of 7** |" in text
    assert "oracle sees of the catalogue | ≥ 90 | **33.3 (0.8 … 90.6) of 3** |" in text
    # The interval of 2 in 7 begins at 3.7 %, which is above 2 %.
    by_world = "| white | **28.6 (3.7 … 71.0) of 7** | **33.3 (0.8 … 90.6) of 3** | "
    assert by_world + "false name 1, falsely adequate 1, silent 1 |" in text
    assert "state no probability" in text
    assert "All 4 sets with an outcome that should not be, or with a second name" in text
    assert "right (latency, and in addition vibration). `arctrue benchmark set FOLDER" in text
    assert "met: unknown, of visible products of parts (100.0 %, goal ≥ 90). Missed: " in text
    assert "Missed: false name (14.3 %, goal ≤ 1); " in text
    assert all(item["command"] in text for item in whole["failures"])
    page_text = benchmark_page({**header_of(sets=7), "commit": None}, whole)
    assert "7 sets, 6 with something" in page_text
    assert "No commit known, source `a`" in page_text


def test_a_class_of_names_where_nothing_is_counts_as_a_false_name() -> None:
    """In a set without a cause, a class of names counts as a false name. In a set with a cause, it
    counts as a class without the cause."""
    names = {"class": ["vibration", "bearing_ball_pass"]}
    sets = [
        judged("ambiguous", **names),
        judged("ambiguous", effect("latency"), **names),
        judged("adequate"),
    ]
    found = {score.name: (score.of(sets).hits, score.of(sets).of) for score in SCORES}
    assert found["false name"] == (1, 3)
    assert found["false name or falsely adequate"] == (1, 3)
    assert found["false name where nothing is"] == (1, 2)


def test_page_tells_goals_of_probabilities_and_the_words_of_an_error() -> None:
    stated = {"latency": 0.9, "none": 0.1}
    right = judged("named", effect("latency"), named="latency", probability=stated)
    failed = judged("error", effect("latency"), error="RuntimeError: no such matrix")
    text = benchmark_page(header_of(sets=2), scored([right, failed]))
    part = "0.900 over the part in the catalogue (goal ≥ 0.470"
    assert f"0.900 over all that the oracle sees, {part}" in text
    # A perfect calibration has one answer of 0.9 right (error 0.1) nine times out of ten, and wrong
    # (error 0.9) once: 0.18 on average.
    said = text.split("| calibration error, simulated | ≤ 0.03 | **0.100** (perfect: ")[1]
    mean, most = said.split(")")[0].split(", ")
    assert float(mean) == pytest.approx(0.18, abs=4 * 0.8 * np.sqrt(0.09 / 1000))
    assert float(most) == pytest.approx(0.9)
    # The only answer with a probability is right, but the best constant states a higher probability
    # than this answer: the gain is log 0.9 − log 0.999.
    assert "constant, simulated | > 0 | **-0.104** (-0.104 … -0.104) |" in text
    assert "(0.900, goal ≥ 0.470)" in text.split("Missed:")[0]
    assert "calibration error, simulated (0.100, goal ≤ 0.03)" in text.split("Missed:")[1]
    assert "error (error: RuntimeError: no such matrix). `arctrue benchmark set FOLDER" in text
    stranger = judged("unknown", effect("flat_track", "stranger"), probability={"unknown": 1.0})
    assert "1.000 over all that the oracle sees. " in benchmark_page(
        header_of(sets=1), scored([stranger])
    )


def test_every_failure_is_listed_up_to_a_number_that_is_reported() -> None:
    sets = [judged("adequate", effect("latency")) for _ in range(MOST_FAILURES + 1)]
    text = benchmark_page(header_of(sets=len(sets)), scored(sets))
    assert text.count("--world white --content one") == MOST_FAILURES
    assert f"{MOST_FAILURES} of {MOST_FAILURES + 1} sets with" in text
    assert "`arctrue benchmark score FOLDER` lists all" in text


def test_answer_of_both_schemas() -> None:
    candidate = {
        "effect": "latency",
        "heldout_before_arcsec": {"capture": 0.3},
        "heldout_after_arcsec": {"capture": 0.1},
    }
    old = {"verdict": "named", "named": "latency", "class": ["latency"], "candidates": [candidate]}
    assert answer_of(old)["probability"] is None
    assert answer_of(old)["held_out_arcsec"] == {"capture": 0.1}
    new = {**old, "verdict": "adequate", "named": None, "probability": {"none": 0.98, "x": 0.02}}
    assert answer_of(new)["probability"] == {"none": 0.98, "x": 0.02}
    assert answer_of(new)["held_out_arcsec"] == {"capture": 0.3}
    assert answer_of({"verdict": "bad_data", "named": None})["further"] == []


@pytest.mark.parametrize("tier", [name for name in TIERS if name != CASES])
def test_tiers_hold_every_world_and_content_and_no_seed_twice(tier: str, tmp_path: Path) -> None:
    plan = make_plan(tier, tmp_path)
    tasks = plan.tasks("arctrue")
    assert len(tasks) == TIERS[tier].sets
    assert len({task["seed"] for task in tasks}) == len(tasks)
    assert len({task_key(task) for task in tasks}) == len(tasks)
    contents = Counter((task["world"], task["content"]) for task in tasks)
    assert {world for world, _ in contents} == set(WORLDS)
    if tier == "sealed":
        of_two_heads = set(WORLDS) - {FOUR_HEADS}
        assert min(contents[world, "nothing"] for world in of_two_heads) >= 300
        assert contents[FOUR_HEADS, "nothing"] >= 150
        assert sum(contents[world, "one"] for world in WORLDS) >= 2_000
        assert sum(contents[world, "stranger"] for world in WORLDS) >= 500
        assert sum(contents[world, "several"] for world in WORLDS) >= 500


@pytest.mark.parametrize("tier", [name for name in TIERS if name != CASES])
def test_every_thirteenth_set_has_four_heads(tier: str, tmp_path: Path) -> None:
    tasks = make_plan(tier, tmp_path).tasks("arctrue")
    of_four = [place for place, task in enumerate(tasks) if task["world"] == FOUR_HEADS]
    assert of_four == list(range(12, len(tasks), 13))


def test_sets_with_two_heads_are_those_from_before_the_world_of_four_heads(tmp_path: Path) -> None:
    tasks = make_plan("quick", tmp_path).tasks("arctrue")
    of_two = [task for task in tasks if task["world"] != FOUR_HEADS]
    assert len(of_two) == 60
    # These are the worlds, contents and seeds of the first and last two sets of the tier at commit
    # 4ecc32a8, which had no set with four heads.
    ends = [*of_two[:2], *of_two[-2:]]
    assert [(task["world"], task["content"], task["seed"]) for task in ends] == [
        ("white", "one", 3849331810340581),
        ("coloured", "one", 2493580720761225),
        ("outliers_and_gaps", "nothing", 1517751046220755),
        ("swinging_speed", "nothing", 1838518442156571),
    ]


def test_sets_of_four_heads_hide_what_heads_show() -> None:
    names, references = set(), Counter[bool]()
    for seed in range(100):
        random = np.random.default_rng([seed, 0])
        found = WORLDS[FOUR_HEADS](random)
        references[found.experiment.reference is not None] += 1
        names |= {item.name for item in hidden("several", random, found.catalogue)}
        off = np.subtract(found.head_places_deg or (), (0.0, 33.0, 162.5, 300.5))
        assert off[0] == 0.0
        assert 0.0 < np.max(np.abs(off)) <= 8.0
    assert names == set(HEADS_SHOW)
    assert references[True] > references[False] > 0
    made = make_set({"world": FOUR_HEADS, "content": "one", "seed": 1, "samples": 200})
    assert made.measurement.capture is not None
    assert len(made.measurement.capture.heads) == 4
    assert {item["effect"] for item in made.truth["effects"]} <= set(HEADS_SHOW)


def test_failures_are_kept_once_and_asked_again(tmp_path: Path) -> None:
    file = tmp_path / "cases.json"
    file.write_text('{"cases": []}')
    failed = judged("adequate", effect("latency"))
    other = replace(failed, task={**failed.task, "seed": 6, "subject": "stepwise_bic"})
    assert keep([failed], "1234567890", file) == 1
    assert keep([failed, other, replace(failed, task={**failed.task, "subject": "y"})], None, file)
    cases = kept_cases(file)
    assert [case["seed"] for case in cases] == [5, 6]
    assert cases[0]["found"] == {
        "hidden": ["latency"],
        "said": "adequate",
        "outcome": "falsely adequate",
        "commit": "1234567890",
    }
    assert case_tasks("arctrue", file)[0] == {**failed.task, "subject": "arctrue"}


def test_reason_of_a_case_stands_with_its_failure_and_stays(tmp_path: Path) -> None:
    file = tmp_path / "cases.json"
    file.write_text('{"cases": []}')
    failed = judged("named", effect("latency"), named="latency", further=["vibration"])
    later = replace(failed, task={**failed.task, "seed": 6})
    assert keep([failed], "1234567890", file) == 1
    reason = Reason("latency, and in addition vibration", "A line is left by the lag.")
    file.write_text(
        json.dumps(
            {"cases": [{**case, "looked_into": asdict(reason)} for case in kept_cases(file)]}
        )
    )
    # A later run adds its cases and keeps the reasons that are already in the file.
    assert keep([failed, later], None, file) == 1
    found = scored([failed, later, replace(failed, answer={"verdict": "adequate"})])
    text = benchmark_page(header_of(sets=3), found, reasons=kept_reasons(file))
    command = "--seed 5 --samples 1500` "
    assert (
        f"and in addition vibration). `{failed.command()}` *Why: A line is left by the lag.*"
        in text
    )
    assert f"`{later.command()}` *Not examined yet.*" in text
    stale = (
        "*Examined when the answer was latency, and in addition vibration: "
        "A line is left by the lag"
    )
    assert f"(adequate). `{failed.command()}` {stale}" in text
    assert text.count(command) == 2
    assert "makes its set again; 2 of 3 have been examined." in text


def test_reasons_in_the_tree_are_sentences() -> None:
    for reason in kept_reasons().values():
        assert reason.said
        assert reason.why.endswith(".")


def test_tier_of_cases_holds_sets_that_can_be_made(tmp_path: Path) -> None:
    plan = make_plan(CASES, tmp_path)
    tasks = plan.tasks("arctrue")
    assert len(tasks) == plan.sets == len({task["seed"] for task in tasks}) == len(kept_cases())
    for task in tasks:
        assert task["world"] in WORLDS or task["world"] in independent_worlds()
        assert task["content"] in (*CONTENTS, HIDDEN)
    # The set of the first task hides the same causes as the first kept case.
    (first, *_), (case, *_) = tasks, kept_cases()
    names = [item["effect"] for item in make_set({**first, "samples": 200}).truth["effects"]]
    assert names == case["found"]["hidden"]


def test_sealed_seed_is_drawn_and_never_twice(tmp_path: Path) -> None:
    seeds = {make_plan("sealed", tmp_path / name).seed for name in "ab"}
    assert len(seeds) == 2
    with pytest.raises(PlanError, match="is there already"):
        make_plan("sealed", tmp_path / "a")
    assert make_plan("dev", tmp_path / "c") == make_plan("dev", tmp_path / "c")


def test_a_plan_of_another_generator_is_refused(tmp_path: Path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    plan = make_plan("quick", tmp_path)
    assert read_plan(tmp_path) == plan
    with pytest.raises(PlanError, match="generator has changed"):
        replace(plan, generator="0").campaign(tmp_path, "arctrue")
    package = tmp_path / "package"
    (package / "table").mkdir(parents=True)
    (package / "table" / "cause.py").write_text("LOW = 1\n")
    monkeypatch.setattr(plan_module, "PACKAGE", package)
    before = plan_module.files_digest(("table",))
    (package / "table" / "cause.py").write_text("LOW = 2\n")
    assert plan_module.files_digest(("table",)) != before


def test_no_plan_and_a_broken_one_are_reported(tmp_path: Path) -> None:
    done = CliRunner().invoke(main, ["benchmark", "run", str(tmp_path)])
    assert done.exit_code == 2
    assert "first arctrue benchmark make" in done.output
    (tmp_path / "plan.json").write_text("{}")
    assert CliRunner().invoke(main, ["benchmark", "run", str(tmp_path)]).exit_code == 2


TASK = {"world": "wrong_statements", "content": "several", "seed": 77, "samples": 200}


def test_a_set_is_its_seed_and_made_again_by_its_command(tmp_path: Path) -> None:
    made = make_set(TASK)
    again = Judged({**TASK, "subject": "x"}, made.truth, {"verdict": "error"}).command()
    folder = tmp_path / "set"
    arguments = again.replace("FOLDER", str(folder)).split()[1:]
    done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 0, done.output
    truth = json.loads((tmp_path / "set.truth.json").read_text(encoding="utf-8"))
    assert truth["effects"] == made.truth["effects"]
    read = read_measurement_set(folder)
    assert read.capture is not None
    assert made.measurement.capture is not None
    np.testing.assert_array_equal(read.capture.head2_counts, made.measurement.capture.head2_counts)
    text = "".join(file.read_text(encoding="utf-8") for file in folder.iterdir())
    assert not any(item["effect"] in text for item in truth["effects"])


def test_nothing_means_nothing_also_where_the_separation_is_stated_wrong() -> None:
    for seed in range(12):
        made = make_set({**TASK, "content": "nothing", "seed": seed})
        assert made.truth["effects"] == []
        assert "head_angle" not in made.truth["adverse_conditions"]


def test_a_subject_that_fails_is_a_miss_not_an_end(monkeypatch) -> None:  # type: ignore[no-untyped-def]
    def fails(folder: Path) -> dict[str, Any]:
        raise RuntimeError("no such matrix")

    monkeypatch.setitem(run_set.__globals__, "find_subject", lambda name: fails)
    result = run_set({**TASK, "subject": "arctrue"})
    assert result["answer"] == {"verdict": "error", "error": "RuntimeError: no such matrix"}
    assert result["set"] == task_digest(TASK)


def finished(folder: Path) -> list[str]:
    """Make a folder with three finished sets of a plan; return the names of the sets."""
    plan = make_plan("quick", folder)
    tasks = plan.tasks("arctrue")[:3]
    truth = {
        "effects": [effect("latency")],
        "noise": [],
        "adverse_conditions": [],
        "floor_arcsec": {},
    }
    with Store(folder / "arctrue", {"plan": asdict(plan), "code": {"arctrue": "a"}}) as store:
        for task in tasks:
            store.add(task, {"truth": truth, "answer": {"verdict": "adequate"}}, 1.0)
    return [set_name(task) for task in tasks]


def test_anybodys_answers_are_scored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = finished(tmp_path)
    assert scored_rate(score_folders([tmp_path], "arctrue", None)) == 0
    answers = tmp_path / "answers.json"
    right = {"verdict": "named", "named": "latency"}
    answers.write_text(json.dumps(dict.fromkeys(names, right)))
    assert scored_rate(score_folders([tmp_path], "arctrue", answers)) == 3
    done = CliRunner().invoke(
        main, ["benchmark", "score", str(tmp_path), "--answers", str(answers)]
    )
    assert done.exit_code == 0, done.output
    assert "right first, of what the oracle sees of the catalogue: 3 of 3" in done.output
    kept = ["benchmark", "score", str(tmp_path), "--keep"]
    refused = CliRunner().invoke(main, [*kept, "--answers", str(answers)])
    assert (refused.exit_code, "--keep needs the answers of a run" in refused.output) == (2, True)
    cases = tmp_path / "cases.json"
    cases.write_text('{"cases": []}')
    keep_in = partial(keep, file=cases)
    monkeypatch.setattr("arctrue.cli.benchmark.keep", keep_in)
    assert "3 new cases" in CliRunner().invoke(main, kept).output
    assert "0 new cases" in CliRunner().invoke(main, kept).output
    assert len(kept_cases(cases)) == 3


def scored_rate(found: dict[str, Any]) -> int:
    rates = found["rates"]["right first, of what the oracle sees of the catalogue"]
    return int(rates["all"]["hits"])


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (lambda answers: answers.popitem(), "1 sets have no answer"),
        (lambda answers: answers.update(x={"verdict": "named"}), "no set is called 'x'"),
        (lambda answers: answers[min(answers)].update(verdict=1), "expected one of"),
        (lambda answers: answers.update({min(answers): 3}), "expected an object, found 3"),
        (lambda answers: answers[min(answers)].update(name="x"), "name: is not known; .* named"),
        (lambda answers: answers[min(answers)].update(probability=3), "probability: expected"),
    ],
)
def test_answers_that_cannot_be_scored_are_refused(tmp_path: Path, change: Any, match: str) -> None:
    answers = {name: {"verdict": "adequate"} for name in finished(tmp_path)}
    change(answers)
    file = tmp_path / "answers.json"
    file.write_text(json.dumps(answers))
    with pytest.raises(AnswersError, match=match):
        score_folders([tmp_path], "arctrue", file)


def test_good_outcomes_are_outcomes() -> None:
    assert set(GOOD) < set(OUTCOMES)
    assert rate([True, False]) == Rate(1, 2)


def test_public_sets_tell_nothing_and_have_one_digest(tmp_path: Path) -> None:
    make_plan("quick", tmp_path / "plan")
    said = []
    for name in "ab":
        arguments = ["benchmark", "sets", str(tmp_path / "plan"), str(tmp_path / name), "--first=2"]
        done = CliRunner().invoke(main, arguments)
        assert done.exit_code == 0, done.output
        said.append(done.output.split()[-1])
    assert said[0] == said[1]
    assert len(said[0]) == 64
    tasks = read_plan(tmp_path / "plan").tasks("arctrue")[:2]
    folders = sorted(item.name for item in (tmp_path / "a").iterdir())
    assert folders == sorted(set_name(task) for task in tasks)
    for folder in (tmp_path / "a").iterdir():
        text = (folder / "measurement.toml").read_text(encoding="utf-8")
        assert not any(str(task["seed"]) in text or task["world"] in text for task in tasks)


def test_public_sets_are_the_frozen_ones(tmp_path: Path) -> None:
    plan = make_plan("public", tmp_path / "plan")
    tasks = plan.tasks("arctrue")
    assert set(frozen_digests()) == {set_name(task) for task in tasks}
    # The test generates one set of each world; ``arctrue benchmark sets`` compares all 216.
    found = {set_name(task): task_digest(task) for task in tasks[6:13]}
    assert {task["world"] for task in tasks[6:13]} == set(WORLDS)
    assert differing(found) == [], "the generator has changed: arctrue benchmark sets --freeze"
    assert differing({**found, next(iter(found)): "0" * 16}) == [next(iter(found))]


def test_sets_that_are_not_the_frozen_ones_are_reported(tmp_path: Path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    make_plan("public", tmp_path / "plan")
    arguments = ["benchmark", "sets", str(tmp_path / "plan"), str(tmp_path / "out"), "--first=1"]
    assert "all of them equal the frozen ones" in CliRunner().invoke(main, arguments).output
    monkeypatch.setattr("arctrue.studies.benchmark.frozen.frozen_digests", dict)
    done = CliRunner().invoke(main, arguments)
    assert done.exit_code == 1
    assert "1 of 1 sets differ from the frozen ones" in done.output
    done = CliRunner().invoke(main, [*arguments, "--freeze"])
    assert done.exit_code == 2
    assert "1 sets cannot be frozen: the tier has 216" in done.output


def test_all_public_sets_can_be_frozen_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """If no digest has changed, ``freeze`` writes the list that the source tree has."""
    file = tmp_path / "public_sets.json"
    monkeypatch.setattr("arctrue.studies.benchmark.frozen.FILE", file)
    freeze(json.loads(FROZEN.read_text(encoding="utf-8"))["sets"])
    assert file.read_bytes() == FROZEN.read_bytes()


def test_smallest_found_and_largest_missed_by_effect() -> None:
    sets = [
        judged("named", effect("latency", limits=2.0), named="latency"),
        judged("named", effect("latency", limits=5.0), named="latency"),
        judged("adequate", effect("latency", limits=3.0)),
        judged("adequate", effect("vibration", limits=0.5)),
        judged("unknown", effect("flat_track", "stranger", limits=9.0)),
    ]
    found = by_effect(sets)
    assert list(found) == ["latency", "vibration"]
    latency = found["latency"]
    assert (latency["hits"], latency["of"]) == (2, 3)
    assert latency["smallest_put_first"] == pytest.approx(2.0)
    assert latency["largest_not_put_first"] == pytest.approx(3.0)
    assert found["vibration"]["smallest_put_first"] is None


def test_the_page_tells_the_independence_of_every_cause_that_the_workbench_can_describe() -> None:
    assert set(INDEPENDENCE) == {*CATALOGUE, *PARTS}


def test_sealed_answers_are_not_scored_by_another_scoring(tmp_path: Path) -> None:
    plan = make_plan("sealed", tmp_path)
    truth = {"effects": [], "noise": [], "adverse_conditions": [], "floor_arcsec": {}}
    with Store(tmp_path / "arctrue", {"plan": asdict(plan), "code": {"arctrue": "a"}}) as store:
        store.add(plan.tasks("arctrue")[0], {"truth": truth, "answer": {"verdict": "error"}}, 1.0)
    assert score_folders([tmp_path], "arctrue", None)["sets"] == 1
    page_text = json.loads((tmp_path / "plan.json").read_text())
    (tmp_path / "plan.json").write_text(json.dumps({**page_text, "scoring": "0"}))
    with pytest.raises(PlanError, match="the scoring has changed since the plan was made"):
        score_folders([tmp_path], "arctrue", None)


def test_answers_of_a_known_seed_may_be_scored_anew_but_not_made_by_another_generator(
    tmp_path: Path,
) -> None:
    plan = make_plan("dev", tmp_path / "dev")
    replace(plan, scoring="0").check()
    with pytest.raises(PlanError, match="the generator has changed"):
        replace(plan, generator="0").check()
    # The public sets may be made by another generator, because their digests are checked; see
    # test_peers.
    replace(make_plan("public", tmp_path / "public"), generator="0").check()


def test_answers_to_the_sets_of_another_plan_are_not_scored(tmp_path: Path) -> None:
    finished(tmp_path)
    page_text = json.loads((tmp_path / "plan.json").read_text())
    (tmp_path / "plan.json").write_text(json.dumps({**page_text, "seed": 7}))
    with pytest.raises(AnswersError, match="answers to the sets of another plan"):
        score_folders([tmp_path], "arctrue", None)
