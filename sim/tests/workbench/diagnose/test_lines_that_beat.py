"""Tests that lines which beat are found together, and that one line whose phase changes is not
taken for several lines."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from arctrue.workbench.inference.forward.oscillation import oscillation_of
from arctrue.workbench.inference.forward.record import record_of
from arctrue.workbench.inference.forward.search import LineSearch, search_lines

ROWS, SPAN_S, SIZE, NOISE = 600, 1800.0, 3.0, 0.3
PERIODS = 20.0
"""Periods of the line in the record."""
SEEDS = [100, *(pytest.param(seed, marks=pytest.mark.large) for seed in (101, 102))]


def _found(seed: int, error: Callable[[np.random.Generator, np.ndarray], np.ndarray]) -> LineSearch:
    """Search a log of 1,800 s; the time of ``error`` is from 0 to about 1."""
    random = np.random.default_rng(seed)
    time_s = np.cumsum(random.uniform(2.5, 3.5, ROWS))
    value = error(random, time_s / SPAN_S) + NOISE * random.normal(size=ROWS)
    one, none = np.zeros(ROWS, dtype=np.int64), np.zeros((ROWS, 0))
    return search_lines(record_of(time_s, time_s, one, value, none, in_time=True))


def _line(periods: float, time: np.ndarray, phase: np.ndarray | float = 0.0) -> np.ndarray:
    return SIZE * np.cos(2.0 * np.pi * periods * time + phase)


@pytest.mark.parametrize("instants", [(0.33, 0.66), (0.2, 0.7)])
@pytest.mark.parametrize("seed", SEEDS)
def test_a_phase_that_changes_twice_is_not_two_lines(seed: int, instants: Sequence[float]) -> None:
    """The search must not describe a line whose phase changes as two lines: the best two, at 18.7
    and 21.5 periods, leave at least a third of it."""
    first, second = instants

    def flipped(_: np.random.Generator, time: np.ndarray) -> np.ndarray:
        within = (time > first) & (time < second)
        return _line(PERIODS, time) * np.where(within, -1.0, 1.0)

    assert _found(seed, flipped).lines == ()


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("end_rad", [0.6, 1.2])
def test_a_phase_that_wanders_gives_no_side_lines(seed: int, end_rad: float) -> None:
    """The line itself, at the mean rate of its phase, is right: a phase of 1.2 rad is 0.2
    periods."""

    def wandering(random: np.random.Generator, time: np.ndarray) -> np.ndarray:
        steps = random.normal(0.0, end_rad / np.sqrt(ROWS), ROWS)
        return _line(PERIODS, time, np.cumsum(steps))

    found = _found(seed, wandering)
    assert [line.rate * SPAN_S for line in found.lines] == [pytest.approx(PERIODS, abs=1.0)]


@pytest.mark.parametrize("beats", [3.0, pytest.param(2.2, marks=pytest.mark.large)])
@pytest.mark.parametrize("seed", SEEDS)
def test_three_lines_that_beat(seed: int, beats: float) -> None:
    """Each amplitude is known to √(2/600)·0.3″ = 0.02″, and a rate to 0.02/(√3·π)·√2 periods. The
    bounds of 0.15 periods and 0.2″ are larger, because the lines share some of their error, and far
    below the beat."""
    periods = [PERIODS, PERIODS + beats, PERIODS + 2.0 * beats + 0.5]

    def three(random: np.random.Generator, time: np.ndarray) -> np.ndarray:
        return np.asarray(sum(_line(one, time, random.uniform(0.0, 6.0)) for one in periods))

    found = _found(seed, three)
    assert sorted(line.rate * SPAN_S for line in found.lines) == pytest.approx(periods, abs=0.15)
    assert [line.amplitude_arcsec for line in found.lines] == pytest.approx([SIZE] * 3, abs=0.2)
    assert oscillation_of(found, "reference") is None
