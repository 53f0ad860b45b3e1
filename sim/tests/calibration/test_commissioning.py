"""Tests that commissioning computes from the readings at which head each cable is connected, in
which direction each head counts, and at which angle each head is."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.calibration.commissioning import Connection, judge_connection

TURN = 1 << 20
PLACES = (0.0, 64.3, 177.0, 257.9)


def judged(
    places: tuple[float, ...] = PLACES,
    *,
    plan: tuple[float, ...] = PLACES,
    sense: tuple[int, ...] = (1, 1, 1, 1),
    moving: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0),
    indexed: tuple[bool, ...] = (True, True, True, True),
    turns: float = 1.1,
) -> Connection:
    """Judge the connection from 40 readings at uneven angles; every reading contains 150″ of
    eccentricity."""
    random = np.random.default_rng(1)
    theta = np.sort(random.uniform(0.0, turns, 40))
    theta[[0, -1]] = 0.0, turns
    nominal = theta[:, None] + np.array(places) / 360.0
    nominal = nominal + 150.0 / 1_296_000.0 * np.cos(2.0 * np.pi * nominal + 1.0)
    counted = np.rint(nominal * np.array(sense) * np.array(moving) * TURN).astype(np.int64)
    # Each position starts at an arbitrary value and wraps at 32 bits.
    positions = (counted + 2**31 - 5000 + 2**31) % 2**32 - 2**31
    return judge_connection(positions, counted % TURN, np.array(indexed), TURN, plan)


def test_heads_as_planned() -> None:
    """Commissioning finds the places within 0.001° from 40 readings with counts of 1.2″; the
    eccentricity does not affect the places."""
    found = judged()
    assert found.faults == ()
    assert found.at_head == (1, 2, 3, 4)
    assert found.places_deg == pytest.approx(PLACES, abs=0.001)


@pytest.mark.parametrize("reversed_head", [1, 2, 3, 4])
def test_a_reversed_head_is_named_and_its_place_found(reversed_head: int) -> None:
    sense = tuple(-1 if head == reversed_head else 1 for head in range(1, 5))
    found = judged(sense=sense)
    (fault,) = found.faults
    assert f"head {reversed_head}: counts in the opposite direction" in fault
    assert f"8 in head{reversed_head}_input" in fault
    assert found.places_deg == pytest.approx(PLACES, abs=0.001)


@pytest.mark.parametrize(
    ("cables", "said"),
    [
        ((0, 1, 3, 2), "cable 3 is at head 4, cable 4 is at head 3"),
        ((1, 0, 2, 3), "cable 1 is at head 2, cable 2 is at head 1"),
        ((2, 3, 0, 1), "cable 1 is at head 3, cable 2 is at head 4"),
    ],
)
def test_exchanged_cables_are_named(cables: tuple[int, ...], said: str) -> None:
    """If a cable is connected to another head, the cable's reading shows the place of this head,
    measured from the head of cable 1."""
    found = judged(tuple(PLACES[head] for head in cables))
    (fault,) = found.faults
    assert said in fault
    assert found.at_head == tuple(head + 1 for head in cables)


def test_a_dead_wire_a_missing_index_and_wrong_directions() -> None:
    (still,) = (one for one in judged(moving=(1.0, 1.0, 0.0, 1.0)).faults if "moved" in one)
    assert still.startswith("head 3: moved by 0.000")
    (index,) = judged(indexed=(True, True, False, True)).faults
    assert index.startswith("head 3: no index detected")
    down = judged(sense=(-1, -1, -1, -1)).faults
    assert any("all heads count down" in one for one in down)
    mirrored = judged(tuple(-place for place in PLACES)).faults
    assert any("the opposite direction" in one for one in mirrored)


def test_places_that_no_cable_explains_are_reported() -> None:
    found = judged((0.0, 70.0, 177.0, 257.9))
    (fault,) = found.faults
    assert "5.70° off at best" in fault
    assert found.at_head == (0, 0, 0, 0)
    assert found.places_deg[1] == pytest.approx(70.0, abs=0.001)


def test_evenly_spaced_heads_are_taken_as_they_are() -> None:
    """The result must name no exchange, because three heads at 120° give the same readings after a
    rotation of the cables."""
    plan = (0.0, 120.0, 240.0)
    readings = np.add.outer(np.linspace(0.0, 1.1, 40), np.array(plan) / 360.0) * TURN
    counted = np.rint(readings).astype(np.int64)
    found = judge_connection(counted, counted % TURN, np.ones(3, dtype=bool), TURN, plan)
    assert (found.faults, found.at_head) == ((), (1, 2, 3))


def test_too_short_a_way_and_other_numbers_of_heads() -> None:
    with pytest.raises(ValueError, match="at least once"):
        judged(turns=0.8)
    with pytest.raises(ValueError, match="has 4 heads, the number of places is 3"):
        judged(plan=PLACES[:3])
