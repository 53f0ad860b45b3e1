"""Tests the sentence on the probabilities of a diagnosis."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from arctrue.workbench.diagnose.probable import THAT_IT_CAN_SHOW, probable


def _said(verdict: str, probability: dict[str, float], **changed: Any) -> list[str]:
    given: dict[str, Any] = {"effect_class": [], "untestable": {}, "unlike": ()} | changed
    result: Any = SimpleNamespace(verdict=verdict, probability=probability, **given)
    return probable(result)


def test_a_class_has_one_number() -> None:
    """Of the class {a, b}, neither is as probable as ``unknown``, but one of the two is more
    probable: 0.30 + 0.28."""
    found = {"none": 0.0, "unknown": 0.42, "a": 0.30, "b": 0.28}
    assert _said("ambiguous", found, effect_class=["a", "b"]) == [
        "Probability of the effect to add next: one of the class (a or b) 58 %, unknown 42 %."
    ]
    (alone,) = _said("ambiguous", found, effect_class=["a"])
    assert alone.endswith("next: unknown 42 %, a 30 %, b 28 %.")


@pytest.mark.parametrize(
    ("verdict", "untestable", "limited"),
    [
        ("adequate", {}, False),
        ("adequate", {"latency": ["a column"]}, True),
        ("cannot_tell", {}, True),
        ("named", {"latency": ["a column"]}, False),
    ],
)
def test_none_is_what_the_set_can_show(
    verdict: str, untestable: dict[str, list[str]], limited: bool
) -> None:
    (said,) = _said(verdict, {"none": 0.9, "unknown": 0.1}, untestable=untestable)
    assert (f"{THAT_IT_CAN_SHOW} 90 %" in said) == limited
    assert limited or "next: none 90 %" in said


def test_a_set_unlike_the_benchmark_is_announced_before_the_number() -> None:
    said = _said("named", {"a": 1.0}, unlike=("it has no reference", "it has 3 heads"))
    assert said[0].endswith("sets like this one: it has no reference; it has 3 heads.")
    assert said[1].startswith("Probability")
