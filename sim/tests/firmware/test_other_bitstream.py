"""Tests a re-arm that finds another core or none: the firmware makes no access that this core's bus
refuses, and refuses a set that this core cannot apply, with the reason."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any

import pytest
from sim.tests.firmware.model_core import Firmware, ModelCore, address
from sim.tests.firmware.test_load import DISC, SUBDIVISION, file_of, send, state
from sim.tests.firmware.test_load_followed import with_direction
from sim.tests.firmware.test_load_real import with_real_orders
from sim.tests.firmware.test_load_table import SCRATCHED, half_load, points_of, table_file
from sim.tests.firmware.test_prepared_sets import OFFSETS, lanes_of
from sim.tests.firmware.test_save import Board, re_armed

from arctrue.device.load import load_frames
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.mean_set import MeanSet
from arctrue.generated.registers import LOCAL_POINTS_ADDRESS

MEAN, MODULATORS, REAL_ORDERS, LOCAL_TABLE = (1 << bit for bit in (3, 5, 6, 7))
ALL = 2 | MEAN | MODULATORS | REAL_ORDERS | LOCAL_TABLE
LANES_OF_A_SMALL_CORE = 3
OPTIONAL = {
    MEAN: range(0x1800, 0x1840),
    MODULATORS: range(address("conditions.width"), address("conditions.word_b") + 4),
    REAL_ORDERS: range(0x1400, address("turn_number") + 4),
    LOCAL_TABLE: range(LOCAL_POINTS_ADDRESS, LOCAL_POINTS_ADDRESS + 0x4000),
}
"""Addresses of each part that a core has only if ``capability`` has the part's bit
(docs/registers.md)."""
PLACE = range(address("local_place.choice"), address("local_place.step_high") + 4)


class RefusingCore(ModelCore):
    """A model of the core whose bus refuses accesses to parts that the core lacks; ``refused``
    lists these accesses."""

    def __init__(self) -> None:
        self.refused: list[str] = []
        super().__init__()
        self.set("version", 0x000800)
        self.set("capability", ALL)

    def look(self, offset: int) -> None:
        capability = self.get("capability")
        wanted = {bit: (where,) for bit, where in OPTIONAL.items()}
        wanted[LOCAL_TABLE] += (PLACE,)
        lost = self.get("identification") != 0x41524354
        if lost and offset != address("identification"):
            self.refused.append(f"{offset:#x} without a core")
        for bit, ranges in wanted.items():
            if not capability & bit and any(offset in where for where in ranges):
                self.refused.append(f"{offset:#x} without bit {bit:#x} of capability")

    def read(self, context: Any, offset: int) -> int:
        self.look(offset)
        return super().read(context, offset)

    def write(self, context: Any, offset: int, word: int) -> None:
        self.look(offset)
        super().write(context, offset, word)


class RefusingBoard(Board):
    def new_core(self) -> ModelCore:
        return RefusingCore()


def mean_file() -> Coefficients:
    mean = MeanSet((40_000, 25_536), OFFSETS[:2])
    return dataclasses.replace(lanes_of(1.0), extension=Extension(mean=mean))


def many_lanes() -> Coefficients:
    return file_of({**DISC.orders, **SUBDIVISION})


def lose(bit: int) -> Callable[[ModelCore], None]:
    return lambda core: core.set("capability", ALL & ~bit)


def shrink(core: ModelCore) -> None:
    core.set("core_configuration", LANES_OF_A_SMALL_CORE | 18 << 8 | 12288 << 16)


CASES = {
    "mean": (mean_file, lose(MEAN), "other_heads"),
    "modulators": (lambda: with_direction(SUBDIVISION), lose(MODULATORS), "no_modulators"),
    "real orders": (lambda: with_real_orders(SUBDIVISION), lose(REAL_ORDERS), "no_real_orders"),
    "table": (table_file, lose(LOCAL_TABLE), "no_local_table"),
    "lanes": (many_lanes, shrink, "too_many_lanes"),
    "too many lanes that follow": (
        lambda: with_real_orders(SUBDIVISION),
        lambda core: core.set("core_configuration", 1 | 18 << 8 | 12288 << 16),
        "too_many_lanes",
    ),
}


@pytest.fixture
def board() -> RefusingBoard:
    made = RefusingBoard()
    made.firmware.send("set orders 8")
    made.work(range(1, 5), disc=SCRATCHED)
    return made


def sent(board: Board, name: str) -> None:
    frames = load_frames(CASES[name][0](), force=True)
    assert set(send(board.firmware, frames)) == {"ok"}
    assert state(board.firmware) == "load waiting"


def disc_of(name: str) -> Any:
    return SCRATCHED if name == "table" else DISC


@pytest.mark.parametrize("name", CASES)
def test_a_set_loaded_before_the_re_arm_is_refused(board: RefusingBoard, name: str) -> None:
    sent(board, name)
    board.work(range(5, 8), disc=disc_of(name))
    assert state(board.firmware) == "load active"
    CASES[name][1](board.core)
    re_armed(board, "rearm")
    assert state(board.firmware) == "load waiting"
    board.work(range(8, 10), disc=disc_of(name))
    assert state(board.firmware) == f"load refused {CASES[name][2]}"
    assert board.core.refused == []
    # The core that the set was made for takes it again.
    board.core.set("capability", ALL)
    board.core.set("core_configuration", 32 | 18 << 8 | 12288 << 16)
    re_armed(board, "rearm")
    board.work(range(10, 12), disc=disc_of(name))
    assert state(board.firmware) == "load active"


@pytest.mark.parametrize("name", CASES)
def test_a_set_received_before_the_re_arm_is_refused(board: RefusingBoard, name: str) -> None:
    sent(board, name)
    CASES[name][1](board.core)
    re_armed(board, "rearm")
    board.work(range(8, 10), disc=disc_of(name))
    assert state(board.firmware) == f"load refused {CASES[name][2]}"
    assert board.core.refused == []


@pytest.mark.parametrize("name", CASES)
def test_a_saved_set_is_not_taken(board: RefusingBoard, name: str) -> None:
    sent(board, name)
    board.work(range(5, 8), disc=disc_of(name))
    assert board.order("save").startswith("ok, record 1")
    board.power_on()
    CASES[name][1](board.core)
    re_armed(board, "rearm")
    board.work(range(8, 10), disc=disc_of(name))
    assert board.status("saved") == ["not_confirmed"]
    assert board.core.refused == []


@pytest.mark.parametrize("lost", ["table", "core"])
def test_without_the_table_a_save_reads_no_points(board: RefusingBoard, lost: str) -> None:
    sent(board, "table")
    board.work(range(5, 8), disc=SCRATCHED)
    assert state(board.firmware) == "load active"
    if lost == "core":
        board.core.set("identification", 0)
    else:
        lose(LOCAL_TABLE)(board.core)
    board.firmware.send("rearm")
    assert (board.firmware.phase == "no_core") == (lost == "core")
    assert board.order("save") == "error: save table_not_held\r\n"
    assert board.core.refused == []


@pytest.mark.parametrize("lost", ["table", "core"])
def test_a_load_that_goes_on_after_the_re_arm_reads_no_core(
    board: RefusingBoard, lost: str
) -> None:
    """The firmware reads nothing from a core that disappears, or loses its table, between two
    frames of a load."""
    half_load(board, "")
    before = points_of(board.firmware)
    frames = load_frames(table_file(0.5))
    if lost == "core":
        board.core.set("identification", 0)
    else:
        lose(LOCAL_TABLE)(board.core)
    board.firmware.send("rearm")
    first = next(n for n, frame in enumerate(frames) if frame.startswith("load points "))
    answers = send(board.firmware, frames[first + 450 :])
    assert set(answers[:-1]) == {"error: load wrong_frame"}
    assert answers[-1].startswith("error: load wrong_")
    assert board.core.refused == []
    assert points_of(board.firmware) == before


def test_the_end_of_a_load_without_a_core_reads_nothing() -> None:
    made = Firmware(RefusingCore())
    made.core.set("identification", 0)
    made.library.application_start(made.application)
    assert made.phase == "no_core"
    assert made.send("load end 0").strip() == "error: load wrong_frame"
    assert made.core.refused == []
