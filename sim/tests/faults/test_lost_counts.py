"""Counts that head 1 drops without a trace: whole periods of A and B."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.faults.conftest import MakeScene
from sim.tests.faults.scene import Scene
from sim.tests.faults.setting import PERIOD_COUNTS, TURN_CLOCKS

SEPARATION_RAD = float(np.deg2rad(33.0))


@pytest.mark.parametrize("counts", [PERIOD_COUNTS, 10 * PERIOD_COUNTS])
def test_dropped_counts(scene: Scene, counts: int) -> None:
    before = scene.bank()
    scene.drop(counts)
    scene.turn(0.3)
    # Nothing tells it before the index.
    assert not scene.faults()
    slipped = scene.compare()
    assert slipped.last_slip == -counts
    assert slipped.illegal == 0
    assert slipped.worse < scene.clean_bound + scene.wrong_place(counts)

    scene.record()
    # At that index, not when the bank is full.
    told_at = scene.instrument.clock
    assert scene.next_turn()["alarms"] == ["zero_lost"]
    assert scene.instrument.clock - told_at < TURN_CLOCKS
    assert scene.bank() == before
    scene.turn(0.5)
    # Uncorrected to the next index, on a ramp.
    assert scene.instrument.read("status.compensating") == 0
    assert scene.compare().worse < (scene.clean_bound + scene.ramp_lag + scene.wrong_place(counts))
    scene.recovers()


def test_slip_that_its_turn_does_not_show(make_scene: MakeScene) -> None:
    """Behind the index of its turn, and too small for a step between two samples.

    The turn is used. A step s of head 1 within it is s/(π·n) in order n of the differences, and
    1/|1 − e^{jnα}| times as much in the error (equation 6): so much worse at the most.
    """
    scene = make_scene(None, {"sample_period": TURN_CLOCKS // 300})
    scene.calibrate()
    scene.to_part(0.5)
    scene.instrument.update("control", capture_enable=0)
    scene.instrument.update("control", capture_enable=1)
    scene.turn(0.7)
    scene.record()
    scene.drop(PERIOD_COUNTS)
    told = scene.next_turn()
    assert told["result"] != "refused"
    scene.turn(0.3)
    orders = np.arange(1, 5)
    gain = float(np.sum(1 / (np.pi * orders * 2 * np.sin(orders * SEPARATION_RAD / 2))))
    used = scene.compare()
    assert used.last_slip == -PERIOD_COUNTS
    assert used.worse < scene.clean_bound + PERIOD_COUNTS * gain + scene.wrong_place(PERIOD_COUNTS)
    # The next index tells it, and the turns after it put it right.
    assert scene.next_turn()["alarms"] == ["zero_lost"]
    for _ in range(6):
        scene.next_turn()
    scene.recovers()
