"""Tests that bursts of noise on A and B of either head do not spoil the output."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.faults.conftest import MakeScene
from sim.tests.faults.scene import Scene
from sim.tests.faults.setting import CLOCKS_A_COUNT, COUNTS, FOLLOWING_LIMIT_COUNTS

from arctrue.instrument import HEAD1_A, HEAD1_B, HEAD1_Z, HEAD2_A, HEAD2_B, HEAD2_Z, PinFault

BURST_TURNS = 0.03
INVERTED = 0.02
"""Probability that a pin is inverted in a clock."""


@pytest.mark.large
def test_burst_on_head_1(scene: Scene) -> None:
    before = scene.bank()
    scene.disturb(BURST_TURNS, invert=HEAD1_A | HEAD1_B, probability=INVERTED)
    scene.turn(0.2)
    assert {"head1.illegal", "head1.overspeed"} & scene.faults()
    assert scene.instrument.read("interrupt_status.head1_fault") == 1
    burst = scene.compare()
    assert burst.illegal == 0
    # The spikes give counts at shorter intervals than the output's edges may have. The output lags,
    # but less than the limit at which its flag is set.
    assert "cannot_keep_up" not in scene.faults()
    wrong = scene.wrong_place(burst.most_slip)
    assert burst.worse < scene.clean_bound + FOLLOWING_LIMIT_COUNTS + wrong
    assert burst.last_slip != 0

    scene.record()
    # The index proves the slip, and the firmware discards the samples taken before the index.
    assert "zero_lost" in scene.next_turn()["alarms"]
    assert scene.bank() == before
    assert scene.instrument.read("status.compensating") == 1
    scene.turn(1.0)
    assert scene.compare().worse < scene.clean_bound + wrong
    scene.recovers()


@pytest.mark.large
def test_burst_on_head_2(scene: Scene) -> None:
    """A burst on head 2 does not change the output, which follows head 1."""
    before = scene.bank()
    scene.disturb(BURST_TURNS, invert=HEAD2_A | HEAD2_B, probability=INVERTED)
    scene.turn(0.2)
    assert {"head2.illegal", "head2.overspeed"} & scene.faults()
    assert scene.instrument.read("interrupt_status.head2_fault") == 1
    assert scene.next_turn()["result"] == "refused"
    assert scene.bank() == before
    scene.is_clean()
    scene.recovers()
    scene.knows_the_separation()


def spikes(scene: Scene) -> list[PinFault]:
    """Return spikes of one clock each on random pins during 0.4 of a turn, too far apart to affect
    each other."""
    random = np.random.default_rng(5)
    pins = (HEAD1_A, HEAD1_B, HEAD1_Z, HEAD2_A, HEAD2_B, HEAD2_Z)
    clocks = scene.instrument.clock + 100 * np.arange(1, 400) + random.integers(0, 60, 399)
    return [PinFault(int(clock), 1, invert=pins[random.integers(6)]) for clock in clocks]


@pytest.mark.parametrize("filter_length", [pytest.param(1, marks=pytest.mark.large), 3])
def test_spikes_end_in_the_filter(make_scene: MakeScene, filter_length: int) -> None:
    # The filter delays an edge next to a spike by up to three clocks, so that the next edge follows
    # it sooner; therefore the smallest permitted spacing is reduced to 2 clocks.
    scene = make_scene(None, {"filter_length": filter_length, "minimum_edge_spacing": 2})
    scene.calibrate()
    scene.to_part(0.2)
    turns = len(scene.firmware.telemetry)
    scene.record()
    scene.instrument.disturb(*spikes(scene))
    scene.turn(0.6)
    assert bool(scene.faults()) == (filter_length == 1)
    if filter_length == 1:
        assert scene.next_turn()["result"] == "refused"
        scene.recovers()
        return
    assert scene.next_turn()["result"] != "refused"
    assert scene.reasons(turns)[0] in ("none", "not_better")
    # The harness's decoder has no filter and would report slips; therefore the comparison uses the
    # true angle alone.
    during = scene.compare(slips=False)
    assert during.illegal == 0
    assert during.most < scene.clean_bound + filter_length / CLOCKS_A_COUNT
    assert scene.instrument.read("head1.index.interval") == COUNTS
