"""A small fixed part of the blind test: the diagnosis sees the folder of a sealed set only."""

from __future__ import annotations

import pytest
from scripts.blind import report
from scripts.blind_cases import Case, all_cases, quick_cases
from scripts.blind_judge import GOOD, Outcome, run_case

LARGEST_HELD_OUT = 1.05
"""Held-out error over the floor after what was named is added: the goal of the long test, with
0.05 more for a reference run of five cycles, whose own scatter over 240 rows is 4.6 %."""


@pytest.mark.parametrize("case", quick_cases(), ids=lambda case: f"{case.experiment}-{case.label}")
def test_what_was_hidden_is_found_and_nothing_else(case: Case) -> None:
    outcome = run_case(case)
    assert outcome.outcome in GOOD, report([outcome])
    for before, after in outcome.held_out_over_floor.values():
        assert after < LARGEST_HELD_OUT + 0.05, (before, after)
    if case.names:
        assert outcome.visible
        assert max(before for before, _ in outcome.held_out_over_floor.values()) > 1.0


def test_the_long_test_has_every_kind_of_set_and_no_seed_twice() -> None:
    cases = list(all_cases())
    seeds = [case.seed for case in cases]
    assert len(set(seeds)) == len(seeds)
    assert {case.experiment for case in cases} == {"full", "lean"}
    assert {len(case.names) for case in cases} == {0, 1, 2}


def outcome(kind: str, names: tuple[str, ...], visible: bool = True) -> Outcome:
    case = Case(names, "full", "middle", 1)
    return Outcome(case, case.label, "1 um", visible, 99.0, kind, "named", "x", [], [], [], {}, 1.0)


def test_report_counts_what_is_wrong() -> None:
    text = report(
        [
            outcome("right", ("vibration",)),
            outcome("false name", ("vibration",)),
            outcome("false name", ()),
            outcome("adequate, rightly", ("latency",), visible=False),
            outcome("unknown, rightly", ("warm_ovality",)),
        ]
    )
    assert "full sets, right first: 1 of 2 (50 %)" in text
    assert "false name, all full sets with one effect: 1 of 4 (25 %)" in text
    assert "false name on sets without any effect: 1 of 1 (100 %)" in text
    assert "with the right parts: 1 of 1 (100 %)" in text
    assert text.count("false name (x)") == 2
