"""Shares that are learned on one generator's answers, scored on another's."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.studies.benchmark.across import across, right_shares
from arctrue.studies.benchmark.outcome import Judged


def _answers(
    right: int, wrong: int, stated: float, kind: str = "name", unsure: int = 0
) -> list[Judged]:
    """Sets with a latency hidden, or nothing, and answers that give ``stated`` to one thing."""

    def one(is_right: bool, value: float) -> Judged:
        hidden = is_right == (kind == "name")
        name = "latency" if kind == "name" else "none"
        effect = {
            "effect": "latency" if is_right or kind != "name" else "vibration",
            "kind": "catalogue",
            "noncentrality": 900.0,
            "needed": 20.0,
            "rms_arcsec": 1.0,
        }
        there = [effect] if hidden or kind == "name" else []
        answer = {"verdict": "named", "named": name, "probability": {name: value, "x": 1 - value}}
        return Judged({"world": "white"}, {"effects": there}, answer)

    sure = [one(at < right, stated) for at in range(right + wrong)]
    return sure + [one(True, 0.6) for _ in range(unsure)]


@pytest.mark.parametrize("kind", ["name", "none"])
def test_shares_are_those_of_sure_answers(kind: str) -> None:
    """Jeffreys: (18 + ½)/(20 + 1); an answer at 0.6 is not sure."""
    shares = right_shares(_answers(18, 2, 0.98, kind, unsure=5))
    assert shares == {kind: pytest.approx(18.5 / 21.0)}


def test_what_the_one_generator_tells_mends_what_the_other_is_told() -> None:
    """Stated at 0.98, right in 80 % of both: the log score by hand, of 100 answers."""
    found = across({"one": _answers(80, 20, 0.98), "two": _answers(160, 40, 0.98)})
    assert [(item.learned_on, item.scored_on, item.sets) for item in found] == [
        ("one", "two", 200),
        ("two", "one", 100),
    ]
    second = found[1]
    share = 160.5 / 201.0
    constant = 0.8 * np.log(0.8) + 0.2 * np.log(0.2)
    assert second.right_share == {"name": pytest.approx(share)}
    of_stated = 0.8 * np.log(0.98) + 0.2 * np.log(0.02) - constant
    of_learned = 0.8 * np.log(share) + 0.2 * np.log(1.0 - share) - constant
    assert second.stated_gain.value == pytest.approx(of_stated)
    assert second.learned_gain.value == pytest.approx(of_learned)
    # Equal probabilities stand in ten bins in the order given: eight are right, two are wrong.
    assert second.stated_error.value == pytest.approx(0.8 * 0.02 + 0.2 * 0.98)
    assert second.learned_error.value == pytest.approx(0.8 * (1.0 - share) + 0.2 * share)
    assert second.stated_gain.low <= second.stated_gain.value <= second.stated_gain.high
    assert "scored on one (100 sets)" in second.words()


def test_a_generator_without_answers_is_an_error() -> None:
    silent = Judged({"world": "white"}, {"effects": []}, {"verdict": "error"})
    with pytest.raises(ValueError, match="generator two has an answer"):
        across({"one": _answers(3, 1, 0.9), "two": [silent]})
