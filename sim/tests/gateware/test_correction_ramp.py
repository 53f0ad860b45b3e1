"""The ramp's model against what it promises, without looking at how it is worked out."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from tb.compensation.correction_ramp_scenarios import (
    COUNT,
    RATE_ONE,
    SCENARIOS,
    UNIT,
    RampScenario,
)

from arctrue.gateware.correction_ramp import RampState, correction_ramp


def run(scenario: RampScenario) -> np.ndarray:
    return correction_ramp(
        scenario.correction, scenario.marker, scenario.limit, scenario.ramp_rate
    ).total


@pytest.mark.parametrize("scenario", SCENARIOS, ids=str)
def test_rate_bound_and_hold(scenario: RampScenario) -> None:
    total = run(scenario)
    before = np.concatenate(([0], total[:-1]))
    assert np.array_equal(total[scenario.marker], before[scenario.marker])
    # One clock hands out at most the rate, rounded up to a whole unit.
    rate_units = -(-scenario.ramp_rate // RATE_ONE)
    change = np.abs(np.diff(total))
    allowed = np.abs(np.diff(scenario.correction)) + rate_units * UNIT
    assert np.all((change <= allowed)[~scenario.marker[1:]])


@pytest.mark.parametrize("scenario", SCENARIOS, ids=str)
def test_equals_a_plain_walk(scenario: RampScenario) -> None:
    """Clock by clock, with the time since the marker as a fraction."""
    held = 0
    caught, age = 0, 0
    top = scenario.limit * COUNT
    for clock, total in enumerate(run(scenario).tolist()):
        correction = int(scenario.correction[clock])
        if scenario.marker[clock]:
            caught, age = held - correction, 0
        else:
            age += 1
            lost = int(Fraction(max(age - 2, 0) * scenario.ramp_rate, RATE_ONE)) * UNIT
            left = max(abs(caught) - lost, 0)
            held = correction + (left if caught > 0 else -left)
            held = max(-top, min(top, held))
        assert total == held, f"clock {clock}"


def test_ramp_ends_at_the_correction() -> None:
    """2 counts at 32 units a clock, 2048 units a count: 128 clocks, 2 clocks after the marker."""
    clocks = 200
    correction = np.full(clocks, 2 * COUNT, dtype=np.int64)
    marker = np.arange(clocks) == 0
    result = correction_ramp(correction, marker, 1000, 32 * RATE_ONE)
    assert result.total[128 + 1] < 2 * COUNT
    assert np.all(result.total[128 + 2 :] == 2 * COUNT)
    assert np.array_equal(result.busy, np.arange(clocks) < 130)
    assert not result.limited.any()


def test_runs_in_pieces_are_one_run() -> None:
    scenario = SCENARIOS[13]
    state = RampState()
    pieces = []
    for start in range(0, scenario.correction.size, 171):
        piece = slice(start, start + 171)
        result = correction_ramp(
            scenario.correction[piece],
            scenario.marker[piece],
            scenario.limit,
            scenario.ramp_rate,
            state,
        )
        state = result.state
        pieces.append(result.total)
    assert np.array_equal(np.concatenate(pieces), run(scenario))


def test_limited_flag_says_clipped() -> None:
    clocks = 8
    correction = np.array([0, 3, 4, 5, -4, -5, 0, 0], dtype=np.int64) * COUNT
    result = correction_ramp(correction, np.zeros(clocks, dtype=bool), 4, 0)
    assert result.limited.tolist() == [False, False, False, True, False, True, False, False]
    assert (result.total // COUNT).tolist() == [0, 3, 4, 4, -4, -4, 0, 0]


@pytest.mark.parametrize("rate", [-1, 2**32])
def test_rate_outside_the_format_is_refused(rate: int) -> None:
    with pytest.raises(ValueError, match="ramp_rate"):
        correction_ramp(np.zeros(1, dtype=np.int64), np.zeros(1, dtype=bool), 4, rate)
