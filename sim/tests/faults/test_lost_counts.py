"""Tests the loss of whole periods of A and B at head 1, which sets no flag."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.faults.conftest import MakeScene
from sim.tests.faults.setting import PERIOD_COUNTS, TURN_CLOCKS

SEPARATION_RAD = float(np.deg2rad(33.0))


@pytest.mark.parametrize(
    ("counts", "heal"),
    [
        pytest.param(PERIOD_COUNTS, 0, marks=pytest.mark.large),
        pytest.param(10 * PERIOD_COUNTS, 0, marks=pytest.mark.large),
        (10 * PERIOD_COUNTS, 1),
    ],
)
def test_dropped_counts(make_scene: MakeScene, counts: int, heal: int) -> None:
    """Head 2 proves the loss of head 1's counts at the next index; the correction is never switched
    off."""
    scene = make_scene(None, {"heal": heal})
    scene.calibrate()
    scene.to_part(0.3)
    scene.record()
    before = scene.bank()
    scene.drop(counts)
    scene.turn(0.3)
    # Before the next index no signal shows the loss.
    assert not scene.faults()
    slipped = scene.compare()
    assert slipped.last_slip == -counts
    assert slipped.illegal == 0
    assert slipped.worse < scene.clean_bound + scene.wrong_place(counts)

    scene.record()
    # The firmware reports the loss at that index, not only later, when the bank is full.
    fault_at = scene.instrument.clock
    assert scene.next_turn()["alarms"] == ["zero_lost"]
    assert scene.instrument.clock - fault_at < TURN_CLOCKS
    assert scene.bank() == before
    assert scene.instrument.read("zero.moves") == 1
    assert scene.instrument.read("zero_slip") == -counts
    assert scene.instrument.read("put_back") == heal * counts
    assert scene.instrument.read("status.compensating") == 1
    scene.turn(0.5)
    errors = scene.compare(slips=not heal)
    assert errors.illegal == 0
    assert errors.worse < scene.clean_bound + scene.wrong_place(counts) + heal * counts
    if heal:
        # The output is right again, because the gateware has added the lost counts, which head 1's
        # own count still lacks.
        scene.settle()
        scene.record()
        scene.turn(1.0)
        healed = scene.compare(slips=False)
        assert healed.most < scene.clean_bound
        assert healed.last_slip == -counts
        return
    # No further turn is lost.
    assert scene.next_turn()["result"] != "refused"
    scene.recovers()


@pytest.mark.large
def test_slip_that_its_turn_does_not_show(make_scene: MakeScene) -> None:
    """The firmware uses a turn with a slip that is too small to show as a step between two samples.

    A step s of head 1 within the turn adds s/(π·n) to order n of the differences, and 1/|1 −
    e^{jnα}| times as much to the error (equation 6). The bound follows from this error.
    """
    scene = make_scene(None, {"sample_period": TURN_CLOCKS // 300})
    scene.calibrate()
    scene.to_part(0.5)
    scene.instrument.update("control", capture_enable=0)
    scene.instrument.update("control", capture_enable=1)
    scene.turn(0.7)
    scene.record()
    scene.drop(PERIOD_COUNTS)
    reply = scene.next_turn()
    assert reply["result"] != "refused"
    scene.turn(0.3)
    orders = np.arange(1, 5)
    gain = float(np.sum(1 / (np.pi * orders * 2 * np.sin(orders * SEPARATION_RAD / 2))))
    used = scene.compare()
    assert used.last_slip == -PERIOD_COUNTS
    assert used.worse < scene.clean_bound + PERIOD_COUNTS * gain + scene.wrong_place(PERIOD_COUNTS)
    # The next index shows the slip, and the following turns correct it.
    assert scene.next_turn()["alarms"] == ["zero_lost"]
    for _ in range(6):
        scene.next_turn()
    scene.recovers()
