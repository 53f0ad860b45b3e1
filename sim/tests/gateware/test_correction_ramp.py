"""Tests the model of the ramp against calculations from the ramp's specification that share no code
with the model."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from sim.tests.gateware.correction_ramp_scenarios import (
    COUNT,
    RATE_ONE,
    SCENARIOS,
    UNIT,
    RampScenario,
)

from arctrue.gateware.correction_ramp import RampState, correction_ramp
from arctrue.gateware.register_access import register_named

LINEAR = [scenario for scenario in SCENARIOS if not scenario.ramp_acceleration]
TICK = 256
"""Number of clocks for which the velocity of the ramp stays constant."""
CLOCK_HZ = 1e8
HOLDS_COUNTS = 2**19
"""The magnitude of the total, which has 19 integer bits, is at most this number of counts."""


def run(scenario: RampScenario) -> np.ndarray:
    return correction_ramp(
        scenario.correction,
        scenario.marker,
        scenario.limit,
        scenario.ramp_rate,
        inserted=jumps(scenario),
        ramp_acceleration=scenario.ramp_acceleration,
    ).total


def reset_value(path: str) -> int:
    """Return the reset value of a register that has a single field."""
    (field,) = register_named(path).fields
    return int(field.reset or 0)


def jumps(scenario: RampScenario) -> np.ndarray:
    none = np.zeros(scenario.correction.size, dtype=np.int64)
    return scenario.inserted if scenario.inserted.size else none


@pytest.mark.parametrize("scenario", SCENARIOS, ids=str)
def test_rate_bound_and_hold(scenario: RampScenario) -> None:
    total = run(scenario)
    before = np.concatenate(([0], total[:-1])) + jumps(scenario) * COUNT
    # If a jump would lead beyond the range of the total, the total goes to the limit.
    fits = scenario.marker & (np.abs(before + 0.5) < HOLDS_COUNTS * COUNT)
    assert np.array_equal(total[fits], before[fits])
    clipped = scenario.marker & ~fits
    assert np.all(np.abs(total[clipped] + 0.5) > (scenario.limit - 1) * COUNT)
    assert np.array_equal(total[clipped] > 0, before[clipped] > 0)
    behind = np.zeros_like(scenario.marker)
    behind[1:] |= scenario.marker[:-1]
    behind[2:] |= scenario.marker[:-2]
    behind &= ~scenario.marker
    assert np.array_equal(total[1:][behind[1:]], total[:-1][behind[1:]])
    # In one clock the ramp changes the total by at most its rate, rounded up to a whole unit of
    # 2⁻²⁷ count.
    rate = -(-scenario.ramp_rate * UNIT // RATE_ONE)
    change = np.abs(np.diff(total))
    ends = UNIT if scenario.ramp_acceleration else 0
    # In the clock in which a hold ends, the total also makes the change of ε over two clocks. The
    # lower limit is one unit further from 0 than the upper limit.
    moved = np.abs(np.diff(scenario.correction))
    moved[1:] += np.abs(np.diff(scenario.correction[:-1]))
    # After a jump that would lead beyond the range, the total lies less than one count beyond the
    # limit; the return to the limit adds this difference to a change.
    at_limit = np.abs(total[:-1] + 0.5) > scenario.limit * COUNT
    jumped = at_limit & np.any(clipped)
    assert np.all((change <= moved + rate + ends + 1 + COUNT * jumped)[~scenario.marker[1:]])


@pytest.mark.parametrize("scenario", LINEAR, ids=str)
def test_equals_a_plain_walk(scenario: RampScenario) -> None:
    """In every clock the total equals the result of a plain calculation, which computes the ramp
    with exact fractions from the time since the marker."""
    held = 0
    caught, age = 0, 3
    top = scenario.limit * COUNT
    for clock, total in enumerate(run(scenario).tolist()):
        correction = int(scenario.correction[clock])
        if scenario.marker[clock]:
            jumped = held + int(jumps(scenario)[clock]) * COUNT
            if abs(jumped + Fraction(1, 2)) > HOLDS_COUNTS * COUNT:
                to = scenario.limit if jumped > 0 else -scenario.limit - 1
                jumped = to * COUNT + jumped % COUNT
            held = jumped
            age = 0
        else:
            age += 1
        if age == 1:
            caught = held - correction
        if age > 2:
            lost = int(Fraction(max(age - 5, 0) * scenario.ramp_rate * UNIT, RATE_ONE))
            left = max(abs(caught) - lost, 0)
            held = correction + (left if caught > 0 else -left)
            held = max(-top - 1, min(top, held))
        assert total == held, f"clock {clock}"


def test_ramp_ends_at_the_correction() -> None:
    """A ramp over 2 counts, which are 4,096 units of 2⁻¹¹ count, takes 128 clocks at 32 units per
    clock; it begins 5 clocks after the marker."""
    clocks = 200
    correction = np.full(clocks, 2 * COUNT, dtype=np.int64)
    marker = np.arange(clocks) == 0
    result = correction_ramp(correction, marker, 1000, 32 * RATE_ONE)
    assert result.total[128 + 4] < 2 * COUNT
    assert np.all(result.total[128 + 5 :] == 2 * COUNT)
    assert np.array_equal(result.busy, np.arange(clocks) < 133)
    assert not result.limited.any()


def test_runs_in_pieces_are_one_run() -> None:
    (scenario,) = [s for s in SCENARIOS if s.name.startswith("random 1,")]
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
    assert (result.total[:5] // COUNT).tolist() == [0, 3, 4, 4, -4]
    # The lower limit is one unit further from 0; the rounding of the output brings it to the limit.
    assert result.total[5:].tolist() == [-4 * COUNT - 1, 0, 0]


@pytest.mark.parametrize("rate", [-1, 2**32])
def test_rate_outside_the_format_is_refused(rate: int) -> None:
    with pytest.raises(ValueError, match="ramp_rate"):
        correction_ramp(np.zeros(1, dtype=np.int64), np.zeros(1, dtype=bool), 4, rate)


@pytest.mark.parametrize("acceleration", [-1, 2**32])
def test_acceleration_outside_the_format_is_refused(acceleration: int) -> None:
    with pytest.raises(ValueError, match="ramp_acceleration"):
        correction_ramp(
            np.zeros(1, dtype=np.int64),
            np.zeros(1, dtype=bool),
            4,
            0,
            ramp_acceleration=acceleration,
        )


def smooth(counts: float, rate: int, acceleration: int, ticks: int) -> np.ndarray:
    """Return r for each clock after a step of ε: the difference, in counts, that the ramp still has
    to remove."""
    clocks = TICK * ticks
    level = np.full(clocks, round(counts * COUNT), dtype=np.int64)
    marker = np.arange(clocks) == 0
    done = correction_ramp(level, marker, 2**19 - 1, rate, ramp_acceleration=acceleration)
    assert not done.busy[-1]
    return (done.total - level) / COUNT


@pytest.mark.parametrize("counts", [2.5, -0.9])
@pytest.mark.parametrize("clocks_to_rate", [1e4, 4e4])
def test_what_a_servo_sees_of_a_ramp(counts: float, clocks_to_rate: float) -> None:
    """Velocity and acceleration of r stay within their bounds, and the duration of the ramp is near
    d/v + v/a, as with constant acceleration."""
    rate, ticks = 1_500_000, 600
    velocity = rate / 2**35
    acceleration = round(rate / clocks_to_rate * 2**24)
    acceleration_clocks = acceleration / 2**59
    r = smooth(counts, rate, acceleration, ticks)
    assert r[0] == pytest.approx(-counts, abs=2**-27)
    assert r[-1] == 0
    at = r[np.arange(0, r.size, TICK)]
    speed = np.diff(at) / TICK
    assert np.all(speed * np.sign(counts) >= 0), "it never goes back"
    assert np.abs(speed).max() <= velocity * (1 + 1e-9)
    # The samples do not lie on the ticks, so a difference can contain two changes of the velocity.
    assert np.abs(np.diff(speed)).max() <= acceleration_clocks * TICK * (1 + 1e-3) + 2**-27
    assert np.abs(speed[:2]).max() <= 2 * acceleration_clocks * TICK
    last = np.flatnonzero(speed)[-1]
    assert np.abs(speed[last]) <= 2 * acceleration_clocks * TICK
    # Apart from a few ticks, the ramp takes at most 10 % longer than with constant acceleration.
    reached = min(velocity, np.sqrt(abs(counts) * acceleration_clocks))
    shortest = abs(counts) / reached + reached / acceleration_clocks
    took = np.flatnonzero(r)[-1]
    assert shortest - 2 * TICK < took < shortest * 1.1 + 12 * TICK


@pytest.mark.parametrize("units", [1, -1, 2, -2])
def test_a_step_of_a_few_units_ends(units: int) -> None:
    """With 17,100 · 2⁻⁵⁹ count per clock², the preset at 2¹⁸ counts, the first step of the velocity
    moves r by less than a unit of 2⁻²⁷ count in a tick."""
    assert smooth(units / COUNT, 1_500_000, 17_100, 40)[-1] == 0


def test_presets_reach_the_rate_in_a_tenth_of_a_second() -> None:
    rate = reset_value("ramp_rate") / 2**35 * CLOCK_HZ
    acceleration = reset_value("ramp_acceleration") / 2**59 * CLOCK_HZ**2
    assert rate == pytest.approx(1900, rel=1e-3)
    assert rate / acceleration == pytest.approx(0.1, rel=1e-3)


@pytest.mark.parametrize(
    "phase",
    [
        0,
        100,
        *(pytest.param(phase, marks=pytest.mark.large) for phase in (238, *range(239, 255, 2))),
        255,
    ],
)
def test_markers_in_every_tick_never_lead_past_the_end(phase: int) -> None:
    """The total never passes the end of a step, even if markers come in every tick.

    The step has 2 counts. From the middle of the ramp on, one marker comes in each 256 clocks,
    always in the same clock of the tick; at the end there are no more markers. Whichever clock this
    is, the total reaches 2 counts and never exceeds them. The velocity of the total never changes
    by more than the acceleration allows.
    """
    counts, rate, acceleration, ticks = 2.0, RATE_ONE * 24, 2**32 - 1, 600
    clocks = TICK * ticks
    level = np.full(clocks, round(counts * COUNT), dtype=np.int64)
    marker = np.arange(clocks) == 0
    half = int(
        np.argmax(
            correction_ramp(level, marker, 2**19 - 1, rate, ramp_acceleration=acceleration).total
            > level / 2
        )
    )
    marker[half - half % TICK + phase : clocks * 2 // 3 : TICK] = True
    done = correction_ramp(level, marker, 2**19 - 1, rate, ramp_acceleration=acceleration)
    assert done.total.max() <= level[0]
    assert done.total[-1] == level[0]
    assert not done.busy[-1]
    near = np.convolve(marker, np.ones(6))[:clocks] > 0
    speed = np.diff(done.total)[~near[1:]] / COUNT
    # In each clock the total changes by whole units, so velocities are averaged over a tick. Such a
    # mean contains at most two velocities.
    mean = np.convolve(speed, np.ones(TICK) / TICK, "valid")
    change = np.abs(mean[TICK:] - mean[:-TICK]).max()
    assert change <= 3 * acceleration / 2**59 * TICK + 2**-27


def test_counts_put_back_beyond_what_the_total_holds_are_clipped_and_reported() -> None:
    """If more counts are put back than the total can hold, the total stays at its limit, which
    `limited` reports; it does not wrap to the opposite sign."""
    for sense in (1, -1):
        (scenario,) = [s for s in SCENARIOS if s.name == f"healed again and again, {sense}"]
        result = correction_ramp(
            scenario.correction,
            scenario.marker,
            scenario.limit,
            scenario.ramp_rate,
            inserted=scenario.inserted,
        )
        total = result.total / COUNT
        assert np.all(np.abs(total) <= scenario.limit + 1)
        moved = np.diff(sense * total)
        assert moved.min() > -1, "it never jumps back"
        asked = 50 + np.cumsum(np.abs(scenario.inserted))
        # The ramp removes one count in 2,048 clocks, and |ε| is at most 50 counts, so the total is
        # still near the limit.
        assert sense * total[-1] > scenario.limit - 52
        assert np.array_equal(result.limited.any(), asked[-1] > scenario.limit)


def test_a_marker_on_the_way_leaves_the_velocity() -> None:
    """The velocity of r does not jump when swaps change ε up and down during a ramp: the ramp slows
    down, reverses and returns."""
    (scenario,) = [s for s in SCENARIOS if s.name == "smooth, markers on the way"]
    total = run(scenario)
    difference = total - scenario.correction
    # The clocks of the markers and of their holds are left out.
    near = np.convolve(scenario.marker, np.ones(4))[: scenario.marker.size] > 0
    speed = np.diff(total)[~near[1:]]
    mean = np.convolve(speed, np.ones(TICK) / TICK, "valid")
    change = np.abs(mean[TICK:] - mean[:-TICK]).max()
    # From one mean to the next the velocity changes by at most 3 * of_a_tick; ``held`` allows for
    # the clocks in which a marker holds the total.
    of_a_tick = scenario.ramp_acceleration / 2**59 * TICK * COUNT
    held = 7 * scenario.ramp_rate / 2**8 / TICK
    assert change <= 3 * of_a_tick + held
    assert difference[-1] == 0
