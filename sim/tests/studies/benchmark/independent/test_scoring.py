"""Tests that the plans contain sets of the independent generator (package ``independent``), and
that the command line makes and scores these sets."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from arctrue.cli import main
from arctrue.report.benchmark_page import benchmark_page
from arctrue.report.benchmark_sets_page import benchmark_sets_page
from arctrue.studies.benchmark.answers import judged_sets
from arctrue.studies.benchmark.independent.world import HIDDEN, NOTHING, independent_worlds
from arctrue.studies.benchmark.intervals import Rate
from arctrue.studies.benchmark.outcome import Judged
from arctrue.studies.benchmark.plan import (
    CASES,
    PlanError,
    files_digest,
    make_plan,
    read_plan,
)
from arctrue.studies.benchmark.score import SCORES, scored
from arctrue.studies.benchmark.sets import make_set
from arctrue.studies.benchmark.worlds import WORLDS

TASK = {"world": "mount_log", "content": HIDDEN, "seed": 7, "samples": 300}


def line(hz: float, rms_arcsec: float) -> dict[str, Any]:
    return {
        "effect": "periodic_error",
        "kind": "catalogue",
        "parts": [],
        "size": 1.0,
        "unit": "arcsec",
        "values": {"hz": [hz]},
        "noncentrality": 1000.0,
        "needed": 40.0,
        "rms_arcsec": rms_arcsec,
    }


def judged(answer: dict[str, Any], *effects: dict[str, Any], **accepted: list[str]) -> Judged:
    truth = {
        "effects": list(effects),
        "noise": [],
        "adverse_conditions": [],
        "accepted": accepted,
        "resolution": {"hz": 0.001, "order": 1.0},
        "floor_arcsec": {"reference": 0.1},
    }
    return Judged({**TASK, "subject": "x"}, truth, answer)


def named(name: str, hz: float | None = None, **more: Any) -> dict[str, Any]:
    parameters = {} if hz is None else {"frequency": hz, "amplitude": 3.0}
    return {"verdict": "named", "named": name, "parameters": parameters, **more}


@pytest.mark.parametrize(
    ("answer", "expected"),
    [
        (named("periodic_error", 0.1), "right"),
        (named("periodic_error", 0.1014), "right"),
        (named("periodic_error", 0.1016), "false name"),
        (named("periodic_error"), "right"),
        (named("vibration", 0.3), "right"),
        (named("bearing_ball_pass", 0.1), "in class"),
        (named("bearing_ball_pass", 0.2), "false name"),
        (named("hysteresis"), "false name"),
        ({"verdict": "ambiguous", "class": ["vibration", "hysteresis"]}, "first in class"),
        ({"verdict": "ambiguous", "class": ["hysteresis", "vibration"]}, "in class"),
        ({"verdict": "ambiguous", "class": ["hysteresis"]}, "class without it"),
        ({"verdict": "unknown"}, "unknown, wrongly"),
    ],
)
def test_a_line_is_right_by_the_accepted_names_where_a_line_is(
    answer: dict[str, Any], expected: str
) -> None:
    """An answer is right if its name is accepted; a stated frequency must be that of a periodic
    error of the set, 0.1 or 0.3 Hz. Two frequencies count as equal if they differ by at most 1.5
    times the resolution, which is 0.001 Hz."""
    lines = (line(0.1, 2.0), line(0.3, 0.5))
    found = judged(answer, *lines, names=["vibration"], alike=["bearing_ball_pass"])
    assert found.outcome == expected


@pytest.mark.parametrize(
    ("verdict", "expected"),
    [
        ({"verdict": "ambiguous", "class": ["hysteresis"]}, "left open, rightly"),
        ({"verdict": "unknown"}, "unknown, rightly"),
        ({"verdict": "cannot_tell"}, "cannot tell, rightly"),
        ({"verdict": "adequate"}, "falsely adequate"),
        (named("hysteresis"), "false name"),
    ],
)
def test_a_design_that_cannot_tell_may_leave_it_open(
    verdict: dict[str, Any], expected: str
) -> None:
    allowed = ["ambiguous", "unknown", "cannot_tell"]
    assert judged(verdict, line(0.1, 2.0), verdicts=allowed).outcome == expected


def oscillation(hz: float, half_width_hz: float) -> dict[str, Any]:
    return {
        "effect": "driven_oscillation",
        "kind": "oscillation",
        "parts": [],
        "size": 0.3,
        "unit": "arcsec",
        "oscillation": {"hz": hz, "half_width_hz": half_width_hz},
        "noncentrality": 400.0,
        "needed": 45.0,
        "rms_arcsec": 0.3,
    }


@pytest.mark.parametrize(
    ("answer", "expected", "falsely_named"),
    [
        ({"verdict": "unknown", "oscillation_hz": 0.109}, "unknown, rightly", False),
        ({"verdict": "unknown", "oscillation_hz": 0.111}, "unknown, wrongly", False),
        ({"verdict": "unknown"}, "unknown, wrongly", False),
        (named("periodic_error", 0.1), "false name", True),
        ({"verdict": "ambiguous", "class": ["vibration"]}, "class without it", True),
        ({"verdict": "adequate", "oscillation_hz": 0.1}, "falsely adequate", False),
        ({"verdict": "cannot_tell"}, "silent", False),
    ],
)
def test_a_driven_oscillation_is_unknown_with_its_frequency(
    answer: dict[str, Any], expected: str, falsely_named: bool
) -> None:
    """The right answer to a driven oscillation of 0.1 Hz, with half power at ± 0.01 Hz, is
    "unknown" with a frequency in this range; every name of the catalogue is wrong."""
    found = judged(answer, oscillation(0.1, 0.01))
    assert (found.outcome, found.falsely_named) == (expected, falsely_named)


def test_a_faint_oscillation_may_be_adequate() -> None:
    faint = {**oscillation(0.1, 0.01), "noncentrality": 44.0}
    assert judged({"verdict": "adequate"}, faint).outcome == "adequate, rightly"


def test_an_answer_that_is_allowed_is_no_miss_of_a_name() -> None:
    rates = {item.name: item for item in SCORES}
    first = rates["right first, of what the oracle sees of the catalogue"]
    unknown = rates["unknown, of visible strangers"]
    stranger = {**line(0.1, 2.0), "kind": "stranger"}
    allowed = ["ambiguous", "unknown"]
    sets = [
        judged({"verdict": verdict}, effect, verdicts=allowed)
        for effect in (line(0.1, 2.0), stranger)
        for verdict in ("ambiguous", "unknown", "cannot_tell")
    ]
    # For the periodic error, "cannot tell" counts as a miss, and the other two answers do not
    # count. For the cause outside the catalogue, "unknown" counts as right and "cannot tell" as a
    # miss.
    assert first.of(sets) == Rate(0, 1)
    assert unknown.of(sets) == Rate(1, 2)


def test_what_is_allowed_for_something_is_not_for_nothing() -> None:
    allowed = {"verdicts": ["ambiguous", "unknown"], "names": ["vibration"]}
    assert judged({"verdict": "unknown"}, **allowed).outcome == "unknown, wrongly"
    found = judged({"verdict": "ambiguous", "class": ["x"]}, **allowed)
    assert found.outcome == "class without it"


def test_probability_of_accepted_answers_counts_as_the_truth() -> None:
    stated = {"periodic_error": 0.5, "vibration": 0.2, "unknown": 0.2, "none": 0.1}
    answer = {**named("periodic_error"), "probability": stated}
    found = judged(answer, line(0.1, 2.0), names=["vibration"], verdicts=["unknown"])
    assert found.probability_of_truth() == pytest.approx(0.9)
    assert judged(answer, line(0.1, 2.0)).probability_of_truth() == pytest.approx(0.5)


def test_the_largest_line_is_to_be_named_first() -> None:
    (score,) = (item for item in SCORES if item.name.startswith("the largest line"))
    large, alike, small = line(0.1, 2.0), line(0.2, 1.7), line(0.3, 0.5)
    sets = [
        judged(named("periodic_error", 0.1), large, small),
        judged(named("periodic_error", 0.3), large, small),
        judged(named("periodic_error", 0.2), large, alike),
        judged(named("periodic_error", 0.1), large),
    ]
    assert (score.of(sets).hits, score.of(sets).of) == (2, 3)


def test_worlds_fail_by_the_lower_end_of_their_interval_and_generators_stand_apart() -> None:
    """A world fails only if the lower end of the interval of its false answers is above the goal.
    By Clopper and Pearson, the interval of 2 false answers in 6 is 4.3 … 77.7 %, and that of 1 in
    6 is 0.4 … 64.1 %."""
    right, false = judged(named("periodic_error"), line(0.1, 2.0)), judged(named("hysteresis"))
    sets = [right] * 4 + [false] * 2
    assert scored(sets)["failed_worlds"] == ["mount_log"]
    assert scored([right] * 5 + [false])["failed_worlds"] == []
    first = replace(right, task={**right.task, "world": "white", "content": "one"})
    found = scored([*sets, first])
    assert found["generators"] == ["simulated", "independent"]
    rates = found["rates"]["false name or falsely adequate"]
    assert {name: (item["hits"], item["of"]) for name, item in rates.items()} == {
        "all": (2, 7),
        "simulated": (0, 1),
        "independent": (2, 6),
        "white": (0, 1),
        "mount_log": (2, 6),
    }


def test_page_tells_both_generators_and_every_world() -> None:
    probability = {"periodic_error": 0.9, "none": 0.1}
    false = judged({**named("hysteresis"), "probability": {"hysteresis": 0.9, "none": 0.1}})
    right = judged({**named("periodic_error"), "probability": probability}, line(0.1, 2.0))
    first = replace(right, task={**right.task, "world": "white", "content": "one"})
    header = {
        "plan": {"tier": "dev", "seed": 2, "sets": 7, "generator": "g", "scoring": "s"},
        "code": {"arctrue": "a"},
        "commit": "1234567890",
        "subject": "arctrue",
    }
    text = benchmark_page(header, scored([*[false] * 2, *[right] * 4, first]))
    assert "| | goal | all | simulated | independent |" in text
    # By Clopper and Pearson, the interval of 2 in 6 begins above 2 %.
    assert "| mount_log | **33.3 (4.3 … 77.7) of 6** | 100.0 (39.8 … 100.0) of 4 | false" in text
    assert "| calibration error, independent | ≤ 0.05 | **" in text
    assert "| calibration error, simulated | ≤ 0.03 | **0.100**" in text
    # Four of these sets come from the independent generator, and one is simulated with the
    # catalogue.
    assert "was not put first: periodic_error 5 of 5." in text
    sets = benchmark_sets_page()
    for name, world in independent_worlds().items():
        assert f"| {name} | {world.about} |" in sets
    # The page lists the worst answer first, even if that set is the last of the plan.
    silent = judged({"verdict": "cannot_tell"}, line(0.1, 2.0))
    text = benchmark_page(header, scored([silent, false]))
    assert text.index("false name (hysteresis)") < text.index("silent (cannot_tell)")


def test_plans_of_the_second_generator_hold_every_world_and_nulls(tmp_path: Path) -> None:
    plan = make_plan("quick", tmp_path, "independent", limit=48, seed=9)
    assert read_plan(tmp_path) == plan
    tasks = plan.tasks("arctrue")
    assert len({task["seed"] for task in tasks}) == plan.sets == 48
    contents = Counter((task["world"], task["content"]) for task in tasks)
    for name, world in independent_worlds().items():
        if world.contents == (NOTHING, HIDDEN):
            assert (contents[name, NOTHING], contents[name, HIDDEN]) == (1, 2)
        else:
            assert contents[name, world.contents[0]] == 3
    assert len(files_digest(("studies/benchmark/independent",))) == 16


def test_a_fifth_of_both_is_of_the_second_generator(tmp_path: Path) -> None:
    tasks = make_plan("quick", tmp_path, "both").tasks("arctrue")
    worlds = [task["world"] for task in tasks]
    assert len(tasks) == 65
    assert sum(world in independent_worlds() for world in worlds) == 13
    assert set(worlds) >= set(WORLDS)
    # The simulated sets are the same as in a plan that has only simulated sets.
    alone = make_plan("quick", tmp_path / "alone").tasks("arctrue")
    assert [task for task in tasks if task["world"] in WORLDS] == alone[:52]


@pytest.mark.parametrize(
    ("tier", "change", "match"),
    [
        ("public", {"source": "independent"}, "are given"),
        (CASES, {"limit": 3}, "are given"),
        ("public", {"samples": 700}, "are given"),
        ("sealed", {"seed": 3}, "is drawn after"),
    ],
)
def test_given_sets_and_drawn_seeds_cannot_be_chosen(
    tier: str, change: dict[str, Any], match: str, tmp_path: Path
) -> None:
    with pytest.raises(PlanError, match=match):
        make_plan(tier, tmp_path, **change)


def test_a_set_is_made_again_by_its_command(tmp_path: Path) -> None:
    made = make_set(TASK)
    again = Judged({**TASK, "subject": "x"}, made.truth, {"verdict": "error"}).command()
    done = CliRunner().invoke(main, again.replace("FOLDER", str(tmp_path / "set")).split()[1:])
    assert done.exit_code == 0, done.output
    truth = json.loads((tmp_path / "set.truth.json").read_text(encoding="utf-8"))
    assert truth["effects"] == made.truth["effects"]


def test_a_plan_is_made_run_and_scored_from_the_command_line(tmp_path: Path) -> None:
    folder = str(tmp_path / "run")
    arguments = ["make", folder, "--tier=quick", "--generator=independent", "--limit=3"]
    arguments += ["--samples=300"]
    for command in (
        [*arguments, "--seed=4"],
        ["run", folder, "--workers=1"],
        ["score", folder, f"--json={tmp_path / 'score.json'}"],
    ):
        done = CliRunner().invoke(main, ["benchmark", *command])
        assert done.exit_code == 0, done.output
    found = json.loads((tmp_path / "score.json").read_text(encoding="utf-8"))
    assert (found["sets"], found["generators"]) == (3, ["independent"])
    assert {item.task["samples"] for item in judged_sets([Path(folder)], "arctrue", None)} == {300}
    assert "calibration error" in done.output
