"""Tests which set a save writes if a mean of the heads is loaded or calibrated."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sim.tests.firmware.model_core import ModelCore
from sim.tests.firmware.test_application import ARCSEC_PER_COUNT
from sim.tests.firmware.test_load import load, state, turn
from sim.tests.firmware.test_own_sets import (
    WORLD,
    BoardWithFourHeads,
    set_places,
)
from sim.tests.firmware.test_prepared_sets import (
    HEADS,
    OFFSETS,
    FailoverCore,
    file_of,
    lanes_of,
)
from sim.tests.firmware.test_save import Board, re_armed

from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.mean_set import MeanSet
from arctrue.gateware.thermal import ThermalLanes

COLD_C, WARM_C = 20.0, 28.0
WARM_COUNTS = abs(np.exp(0.3j) + WARM_C - COLD_C)
"""Amplitude of order 3 at 28 °C: 1 count at phase 0.3 rad, plus 1 count of cosine per kelvin."""
AMPLITUDE_ONE = 2048
HEAD_MOVED_COUNTS = 4_660
"""Motion of head 2 along the scale by 360″: more than ``alarm_separation_arcsec``, and less than
the 0.25° at which a head is not found."""


class FailoverBoard(Board):
    def new_core(self) -> ModelCore:
        return FailoverCore()


def following(file: Coefficients) -> Coefficients:
    slope = {3: np.array([1.0, 0.0, 0.0, 0.0])}
    return replace(file, thermal=ThermalLanes.from_slopes(slope, COLD_C))


def lanes(coefficients: Any) -> dict[int, tuple[float, int]]:
    """Return (amplitude in counts, phase word) of each used lane, by order."""
    every = [coefficients.lane[place] for place in range(coefficients.lanes)]
    return {
        one.order: (one.amplitude / AMPLITUDE_ONE, one.phase_offset) for one in every if one.order
    }


@pytest.fixture
def warm() -> FailoverBoard:
    """Return a board whose loaded mean follows the temperature, at 28 °C."""
    board = FailoverBoard()
    board.firmware.send("set orders 8")
    board.firmware.turn(turn(1))
    assert load(board.firmware, following(file_of())) == "ok"
    board.firmware.send(f"temperature {COLD_C}")
    board.firmware.turn(turn(2))
    assert state(board.firmware) == "load active"
    board.firmware.send(f"temperature {WARM_C}")
    board.firmware.step(5)
    assert lanes(board.firmware.application.active)[3][0] == pytest.approx(WARM_COUNTS, abs=1e-3)
    return board


@pytest.mark.parametrize("line", ["", "rearm", "set ramp_arcsec_s 100"])
def test_a_loaded_mean_follows_the_temperature_after_power_on(
    warm: FailoverBoard, line: str
) -> None:
    """The record holds the lanes at T₀ and their slopes, also if no turn has judged the set since a
    re-arm. The bound is the amplitude's quantum."""
    if line:
        re_armed(warm, line)
    assert warm.order("save").startswith("ok, record 1: parameters and 2 orders")
    warm.power_on()
    warm.firmware.send(f"temperature {WARM_C}")
    warm.firmware.turn(turn(4))
    warm.firmware.step(3)
    assert warm.status("saved") == ["confirmed"]
    for celsius, counts in ((WARM_C, WARM_COUNTS), (COLD_C, 1.0)):
        warm.firmware.send(f"temperature {celsius}")
        warm.firmware.step(5)
        found = lanes(warm.firmware.application.active)[3][0]
        assert found == pytest.approx(counts, abs=1.0 / AMPLITUDE_ONE)


def test_a_rejected_mean_is_not_saved(warm: FailoverBoard) -> None:
    """Head 2 is elsewhere than the mean states, and ``freeze`` keeps the device from a calibration
    of its own: there are no coefficients to save."""
    warm.firmware.send("freeze on")
    re_armed(warm, "rearm")
    moved = turn(5)
    moved[1] += HEAD_MOVED_COUNTS
    warm.firmware.turn(moved)
    assert state(warm.firmware) == "load refused worse_prediction"
    assert warm.order("save") == "ok, record 1: parameters and 0 orders\r\n"


def world(seed: int, moved: bool = False) -> Any:
    counts = replace(WORLD, seed=seed).counts()
    counts[1] += HEAD_MOVED_COUNTS * moved
    return counts


@pytest.fixture
def contradicted() -> BoardWithFourHeads:
    """Return a board that calibrates its own mean of four heads after a turn has contradicted a
    loaded mean that follows the temperature; this mean is also in record 1."""
    board = BoardWithFourHeads()
    board.firmware.send(f"temperature {COLD_C}")
    set_places(board.firmware, WORLD)
    board.core.see_index()
    board.firmware.step()
    board.firmware.turn(world(1))
    board.firmware.step(3)
    own = board.firmware.application.active.mean
    mean = MeanSet(tuple(own.weight), tuple(own.offset))
    file = following(replace(lanes_of(1.0), extension=Extension(mean=mean)))
    assert load(board.firmware, file) == "ok"
    board.firmware.turn(world(2))
    board.firmware.step(3)
    assert state(board.firmware) == "load active"
    assert board.order("save").startswith("ok, record 1: parameters and 2 orders")
    return board


def calibrate_its_own(board: BoardWithFourHeads) -> dict[int, tuple[float, int]]:
    """Run turns with a moved head and return the lanes of the mean that the device calibrates."""
    for seed in (3, 4):
        board.firmware.turn(world(seed, moved=True))
        board.firmware.step(3)
    found = lanes(board.firmware.application.active)
    assert board.firmware.application.has_active
    assert set(found) > {2, 3, 5}, "not the orders 3 and 7 of the loaded mean"
    return found


@pytest.mark.parametrize("re_arms", [False, True])
def test_its_own_mean_is_saved_without_the_temperature_of_another(
    contradicted: BoardWithFourHeads, re_arms: bool
) -> None:
    board = contradicted
    re_armed(board, "rearm")
    own = calibrate_its_own(board)
    if re_arms:
        re_armed(board, "rearm")
    assert board.order("save").startswith("ok, record 2: ")
    assert lanes(board.save.content.loaded) == own
    assert board.save.content.thermal.lanes == 0
    board.power_on()
    board.firmware.send(f"temperature {WARM_C}")
    board.firmware.turn(world(5, moved=True))
    board.firmware.step(3)
    assert board.status("saved") == ["confirmed"]
    assert lanes(board.firmware.application.active) == own


def test_a_save_keeps_a_mean_that_waits(contradicted: BoardWithFourHeads) -> None:
    """After a re-arm the record waits for a turn again; a save keeps it, although the device had
    calibrated a mean of its own before."""
    board = contradicted
    before = lanes(board.save.content.loaded)
    board.power_on()
    calibrate_its_own(board)
    assert board.status("saved") == ["not_confirmed"]
    re_armed(board, "rearm")
    assert board.status("saved") == ["waiting"]
    assert board.order("save").startswith("ok, record 2: parameters and 2 orders")
    board.power_on()
    assert lanes(board.save.content.loaded) == before
    assert board.save.content.thermal.lanes == 1
    assert lanes(board.save.content.own) == {}


class HeadsBoard(Board):
    """A board whose core has the number of heads and the generic MEAN of ``capability``; the
    further heads repeat the readings of the first two."""

    capability = 2 | 1 << 3

    def new_core(self) -> ModelCore:
        core = FailoverCore() if self.capability & 7 > 2 else ModelCore()
        core.set("version", 0x000800)
        core.set("capability", self.capability)
        return core


def saved_mean_of(heads: int) -> HeadsBoard:
    """Return a board with a saved mean of this number of heads."""
    board = HeadsBoard()
    board.capability = heads | 1 << 3
    board.power_on()
    board.firmware.send("set orders 8")
    board.firmware.turn(turn(1))
    weights = (40_000, 25_536) if heads == 2 else (30_000, 10_000, 25_536)
    mean = MeanSet(weights, OFFSETS[:heads])
    file = replace(lanes_of(1.0), extension=Extension(mean=mean))
    assert load(board.firmware, file) == "ok"
    board.firmware.turn(turn(2))
    assert state(board.firmware) == "load active"
    assert board.order("save").startswith("ok, record 1: parameters and 2 orders")
    return board


@pytest.mark.parametrize(
    ("saved_heads", "capability"),
    [(2, 2), (2, 3 | 1 << 3), (2, 4 | 1 << 3), (3, 2 | 1 << 3), (3, 2), (3, 4 | 1 << 3)],
)
def test_a_saved_mean_of_other_heads_is_not_taken(saved_heads: int, capability: int) -> None:
    """A core without MEAN would apply the lanes of the mean to head 1; a core with another number
    of heads has no place for the words. The device calibrates instead."""
    board = saved_mean_of(saved_heads)
    board.capability = capability
    board.power_on()
    assert board.status("saved") == ["waiting"]
    assert board.firmware.turn(turn(3))["alarms"] == ["not_confirmed"]
    assert board.status("saved") == ["not_confirmed"]
    board.firmware.turn(turn(4))
    board.firmware.step(3)
    active = board.firmware.application.active
    assert board.firmware.application.has_active
    assert active.mean.heads == 0
    # The order 1 of the disc, 150″, has a lane: these are no lanes of the mean.
    assert lanes(active)[1][0] == pytest.approx(150.0 / ARCSEC_PER_COUNT, rel=1e-3)


@pytest.mark.parametrize("saved_heads", [2, 3])
def test_a_saved_mean_of_these_heads_is_taken(saved_heads: int) -> None:
    board = saved_mean_of(saved_heads)
    board.power_on()
    board.firmware.turn(turn(3))
    assert board.status("saved") == ["confirmed"]
    assert board.firmware.application.active.mean.heads == saved_heads


def test_the_mean_is_calibrated_after_a_record_of_other_heads() -> None:
    """A record of three heads does not keep a core with four from the calibration of its mean."""
    chip = saved_mean_of(3).chip
    board = BoardWithFourHeads(chip)
    set_places(board.firmware, WORLD)
    board.core.see_index()
    board.firmware.step()
    assert board.status("saved") == ["waiting"]
    assert "not_confirmed" in board.firmware.turn(world(1))["alarms"]
    board.firmware.step(3)
    assert board.firmware.turn(world(2))["mean_of_heads"] == HEADS
