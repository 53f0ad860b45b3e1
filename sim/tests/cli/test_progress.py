"""Tests that a long command reports its progress and the remaining time."""

from __future__ import annotations

import math

import pytest

from arctrue.base.printable import time_left
from arctrue.cli import _progress
from arctrue.cli._progress import Progress
from arctrue.instrument.run_progress import RunProgress


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(0.4, "0 s"), (89.0, "89 s"), (91.0, "2 min"), (7200.0, "2.0 h"), (math.inf, "?")],
)
def test_time_left(seconds: float, text: str) -> None:
    assert time_left(seconds) == text


def test_steps_have_a_share_and_the_time_left(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = [100.0]
    monkeypatch.setattr(_progress.time, "monotonic", lambda: clock[0])
    shown: list[str] = []
    monkeypatch.setattr(Progress, "_show", lambda self, text: shown.append(text))
    step = Progress("diagnosing", steps=4)
    for name in ("a", "b", "c"):
        step.now(name)
        clock[0] += 10.0
    # Each step lasts 10 s; after the first one, three of four steps remain.
    assert shown == ["a (0 %, ? left)", "b (25 %, 30 s left)", "c (50 %, 20 s left)"]
    for name in ("d", "e", "f"):
        step.now(name)
    assert shown[-1].startswith("f (99 %"), "more steps than expected"


def test_without_a_number_of_steps_nothing_is_made_up(monkeypatch: pytest.MonkeyPatch) -> None:
    shown: list[str] = []
    monkeypatch.setattr(Progress, "_show", lambda self, text: shown.append(text))
    Progress("sending").now("12 of 40 frames sent")
    assert shown == ["12 of 40 frames sent"]


def test_the_instrument_tells_the_share_of_its_motion() -> None:
    now = RunProgress("second turn", 24_800_000, 287_000.0, 2.0 * math.pi, 0.61, 50.0)
    assert now.words == (
        "second turn: 61 % of this motion, 50 s left; table at 1.00 turns, "
        "24.8 million clocks, 287 thousand a second"
    )
    without = RunProgress("pins", 1_000_000, 1000.0, math.nan)
    assert without.words == "pins: 1.0 million clocks, 1 thousand a second"
