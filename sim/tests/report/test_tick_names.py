"""Tests that the names of ticks neither overlap nor extend beyond the end of the axis."""

from __future__ import annotations

import pytest

from arctrue.report.charts.chart import Axis
from arctrue.report.charts.tick_names import tick_names

STEPS = ("fit\nthe first model", "add\nautocollimator gain", "add\nhigh order graduation")


@pytest.mark.parametrize("letters", [200, 90, 60, 45, 30])
@pytest.mark.parametrize("steps", [1, 2, 4, 6])
def test_a_line_of_a_name_is_no_longer_than_its_room(steps: int, letters: int) -> None:
    ticks = [(float(n), f"{n + 1} {STEPS[min(n, 2)]}") for n in range(steps)]
    names = [name for _, name in tick_names(Axis("step", ticks=ticks), letters)]
    assert len(names) == steps
    for number, name in enumerate(names):
        assert name.startswith(f"{number + 1}")
        assert max(map(len, name.split("\n"))) * steps <= letters
    if letters == 200:
        assert "autocollimator gain" in " ".join(names).replace("\n", " ") or steps == 1


def test_of_numbers_some_are_left_out() -> None:
    ticks = [(float(n), str(n)) for n in range(40)]
    assert len(tick_names(Axis("order", ticks=ticks), 200)) == 40
    kept = [name for _, name in tick_names(Axis("order", ticks=ticks), 60)]
    assert kept == [str(n) for n in range(0, 40, 2)]


def test_a_name_without_end_is_cut() -> None:
    ticks = [(0.0, "1 add\n" + "word " * 200), (1.0, "2 add\n" + "x" * 500)]
    for _, name in tick_names(Axis("step", ticks=ticks), 60):
        assert name.count("\n") == 4
        assert name.endswith("…")
