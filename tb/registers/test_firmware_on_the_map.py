"""Runs the firmware on cores with two and three heads; the handwritten register map decides which
of its accesses the gateware would refuse.

On the device a refused access is a data abort, which restarts the processor. The test needs no
simulator; it is in this folder because the register map is here.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sim.tests.firmware.calibrator import BOTH_INDICES_SEEN, words_of_bank
from sim.tests.firmware.library import firmware
from sim.tests.firmware.model_core import ModelCore, bit
from sim.tests.firmware.test_heads import PLACES, World
from sim.tests.firmware.test_load import load, state
from sim.tests.firmware.test_prepared_sets import COUNTS, FURTHER_INDICES_SEEN, LANES, FailoverCore
from sim.tests.firmware.test_save import Board

from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.mean_set import MeanSet
from tb.registers.arctrue_registers_model import RegisterModel, driven_ports

DEPTH = 12288
PLACE_PARAMETERS = ("separation_deg", "head3_deg", "head4_deg")
COMMANDS = (
    *("version", "status", "heads", "show harmonics", "trigger", "sync", "probe", "compare"),
    *("compare 1000 2000", "compare off", "load status", "telemetry on", "come_back 2"),
    *("word a 0.5", "clear_output", "bypass on", "bypass off", "set failover_causes 1"),
    *("set filter_length 2", "set orders 9", "dump", "rearm", "forget"),
)
MEAN, MEAN_WORDS = 0x1800, 9
SETS, SET_BYTES, MEAN_OF_SET = 0x8000, 0x1000, 0x800


class CoreOfTheMap(FailoverCore):
    """A core with MEAN that records each access to an address that the handwritten map refuses."""

    def __init__(self, heads: int, *, failover: bool) -> None:
        self.heads = heads
        self.map = RegisterModel(
            lanes=LANES,
            capture_depth=DEPTH,
            inputs=dict.fromkeys(driven_ports(), 0),
            heads=heads,
            has_mean=True,
            has_failover=failover,
        )
        self.refused: list[tuple[str, str]] = []
        super().__init__()
        self.set("capability", heads | 1 << 3 | failover * bit("capability", "failover"))
        ffi, _ = firmware()
        self.further: Any = None
        self._further = ffi.callback(
            "core_capture_words", lambda *_: ffi.cast("int32_t *", self.further.ctypes.data)
        )
        self.access.further_capture = self._further

    def read(self, context: Any, offset: int) -> int:
        if not self.map.read(offset)[0]:
            self.refused.append(("read", hex(offset)))
        return super().read(context, offset)

    def write(self, context: Any, offset: int, word: int) -> None:
        if not self.map.write(offset, word, 0b1111):
            self.refused.append(("write", hex(offset)))
        super().write(context, offset, word)

    def hand_over(self, counts: Any, flags: int = BOTH_INDICES_SEEN, travel: int = 0) -> None:
        seen = FURTHER_INDICES_SEEN if self.heads > 2 else 0
        ModelCore.hand_over(self, counts[:2], flags | seen, travel)
        # The words of head 4 are not built; the model has other words there, which the firmware
        # must not use.
        garbage = np.full((4 - len(counts), counts.shape[1]), -123_456_789)
        self.further = words_of_bank(np.vstack([counts[2:], garbage]))
        for head, row in enumerate(counts, start=1):
            there = "snapshot." if head < 3 else ""
            last = "_" if head < 3 else "."
            self.set(f"{there}head{head}{last}turn_position", int(row[-1]))
            self.set(f"{there}head{head}{last}angle", int(row[-1]) % COUNTS)


class BoardOfTheMap(Board):
    """A board whose core has MEAN and this number of heads."""

    def __init__(self, heads: int, *, failover: bool) -> None:
        self.heads = heads
        self.failover = failover
        super().__init__()

    def new_core(self) -> ModelCore:
        return CoreOfTheMap(self.heads, failover=self.failover)


def offsets_of(heads: int) -> tuple[int, ...]:
    return tuple(round(place / 360.0 * COUNTS * 16) for place in PLACES[heads])


def mean_file(heads: int, *, failover: bool) -> Coefficients:
    """Return a mean of all heads and, with failover, its sets for each missing head."""
    offsets = offsets_of(heads)
    lanes = Coefficients.from_harmonics([3, 7], [1.0, 0.5], [0.3, 1.9], COUNTS, LANES)
    weights = [20_000 + 1_000 * head for head in range(heads)]
    weights[0] += 65_536 - sum(weights)
    sets = []
    for missing in range(1, heads + 1) if failover else ():
        parts = [0 if head == missing else 30_000 for head in range(1, heads + 1)]
        carrier = 2 if missing == 1 else 1
        parts[carrier - 1] += 65_536 - sum(parts)
        mean = MeanSet(tuple(parts), offsets, carrier, missing)
        sets.append(replace(lanes, offset=missing, extension=Extension(mean=mean)))
    mean = MeanSet(tuple(weights), offsets)
    return replace(lanes, extension=Extension(mean=mean, without=tuple(sets)))


@pytest.mark.parametrize(("heads", "failover"), [(2, False), (3, False), (3, True), (4, True)])
def test_the_firmware_uses_only_words_that_are_built(heads: int, failover: bool) -> None:
    """The firmware calibrates, loads a mean with its prepared sets, saves them, and restores them
    after a loss of power; no access goes to a word that the core does not contain. The core gets
    the words of the built heads."""
    board = BoardOfTheMap(heads, failover=failover)
    seeds = iter(range(1, 100))

    def core() -> Any:
        return board.core

    def counts() -> Any:
        return World(heads=heads, noise_arcsec=0.1, samples=3000, seed=next(seeds)).counts()

    def turn() -> dict[str, Any]:
        telemetry = board.firmware.turn(counts())
        board.firmware.step(3)
        return telemetry

    def built_words(first: int) -> list[int]:
        places = [word for word in range(MEAN_WORDS) if word == 8 or word % 4 < heads]
        return [core().words.get(first + 4 * word, 0) for word in places]

    board.firmware.send("set orders 8")
    for name, place in zip(PLACE_PARAMETERS[: heads - 1], PLACES[heads][1:], strict=True):
        board.firmware.send(f"set {name} {place}")
    core().see_index()
    board.firmware.step()
    telemetry = turn()
    assert telemetry["result"] == "applied"
    assert telemetry.get("mean_of_heads") == (heads if heads > 2 else None)
    assert core().refused == []

    coefficients = mean_file(heads, failover=failover)
    assert load(board.firmware, coefficients) == "ok"
    turn()
    assert state(board.firmware) == "load active"
    assert core().refused == []

    assert coefficients.extension is not None
    entries = [coefficients, *coefficients.extension.without]
    words = []
    for entry in entries:
        assert entry.extension is not None
        assert entry.extension.mean is not None
        every = entry.extension.mean.words()
        words.append([w for n, w in enumerate(every) if n == 8 or n % 4 < heads])
    assert built_words(MEAN) == words[0]
    missing = range(1, heads + 1) if failover else range(0)
    assert board.status("set_without_head") == [str(head) for head in missing]
    for head in missing:
        assert built_words(SETS + SET_BYTES * head + MEAN_OF_SET) == words[head]

    assert board.order("save").startswith("ok, record 1")
    for command in COMMANDS:
        board.firmware.send(command)
        core().see_index()
        board.firmware.step(3)
        core().hand_over(counts())
        board.firmware.step(6)
        assert core().refused == [], command
    board.power_on()
    turn()
    assert board.status("saved") == ["confirmed"]
    assert built_words(MEAN) == words[0]
    for head in missing:
        assert built_words(SETS + SET_BYTES * head + MEAN_OF_SET) == words[head]
    assert core().refused == []
