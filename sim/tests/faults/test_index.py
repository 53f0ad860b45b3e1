"""Tests that the correction stays right after a lost index and after a false index."""

from __future__ import annotations

import pytest
from sim.tests.faults.scene import Scene

from arctrue.instrument import HEAD1_Z, HEAD2_Z

Z_OF = {"head1": HEAD1_Z, "head2": HEAD2_Z}


@pytest.mark.parametrize("head", ["head1", pytest.param("head2", marks=pytest.mark.large)])
def test_lost_index(scene: Scene, head: str) -> None:
    """The gateware detects a missed index at the next index, two turns after the one before; no
    count is lost."""
    scene.to_part(0.7)
    first = scene.instrument.read(f"{head}.index.position")
    scene.disturb(0.5, low=Z_OF[head])
    scene.turn(0.6)
    assert scene.instrument.read(f"{head}.index.position") == first
    assert not scene.faults()
    assert scene.instrument.read("interrupt_status.head1_fault") == 0
    reply, swaps = scene.last_reply, scene.last_reply["swaps"]
    while reply["result"] != "refused":
        swaps, reply = reply["swaps"], scene.next_turn()
    assert reply["reason"] == "index_error"
    assert reply["swaps"] == swaps
    assert "zero_lost" not in reply["alarms"]
    assert scene.instrument.read(f"interrupt_status.{head}_fault") == 1
    assert scene.instrument.read("status.compensating") == 1
    scene.is_clean()
    scene.recovers()


@pytest.mark.parametrize("head", [pytest.param("head1", marks=pytest.mark.large), "head2"])
def test_false_index(scene: Scene, head: str) -> None:
    """A pulse of two counts on Z, in the middle of a turn, must not change the angle."""
    before = scene.bank()
    scene.disturb(2 / 16384, high=Z_OF[head])
    scene.turn(0.1)
    assert scene.faults() == {f"{head}.index_error"}
    assert scene.instrument.read("status.compensating") == 1
    assert scene.next_turn()["reason"] == "index_error"
    assert scene.bank() == before
    # The true index after the false pulse confirmed the zero, so that the core kept the zero.
    assert scene.instrument.read("zero.moves") == 0
    assert "zero_lost" not in scene.last_reply["alarms"]
    scene.is_clean()
    scene.recovers()
