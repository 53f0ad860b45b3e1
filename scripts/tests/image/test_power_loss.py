"""Tests that the device starts with the old or the new content after a power loss in a write or an
erase.

The chip's model writes the page or sector only in part: up to a byte, for many bytes, and in three
orders (flash_model.Chip.lose_power). The tests then check which record or image the C code
finds.
"""

from __future__ import annotations

import struct
from typing import Any

import numpy as np
import pytest
from sim.tests.firmware.flash_model import Chip
from sim.tests.firmware.test_save import REGION, STEPS_MOST, Board, Memory, places_of, turn

from arctrue.device.flash import GOLDEN, write_image
from scripts.image import boot_image
from scripts.tests.image import test_image_store
from scripts.tests.image.test_image_store import NEW, OLD, program, silent, starts

ORDERS = ("up", "down", "none")
RECORD_BYTES = 4096
SECTORS = 16
"""Number of sectors of 64 KB in the region of the records."""


class Torn:
    """Simulates a power loss at many places of each write of the chip, calls ``look`` after each,
    and restores the chip."""

    def __init__(self, chip: Chip, look: Any, every_byte: int) -> None:
        """Store the chip. In a page, power is lost at every byte; in a sector, at each of the first
        ``every_byte`` bytes, at 40 random bytes behind them, and at the last byte."""
        self.chip = chip
        self.look = look
        self.every_byte = every_byte
        self.draw = np.random.default_rng(1)
        self.cuts = 0
        self._finish = chip.finish
        chip.finish = self.finish  # type: ignore[method-assign]

    def places(self, number: int) -> list[int]:
        if number <= 256:
            return list(range(number))
        behind = self.draw.integers(self.every_byte, number, 40)
        return [*range(self.every_byte), *map(int, behind), number - 1]

    def finish(self, until_us: int) -> None:
        self._finish(until_us)
        chip, under_way = self.chip, self.chip.under_way
        assert under_way is not None
        first, old = under_way
        whole = bytes(chip.content[first : first + len(old)])
        for order in ORDERS:
            for place in self.places(len(old)):
                chip.lose_power(place, self.draw, order)
                self.cuts += 1
                self.look(f"{order} {first:#x} + {place:#x}")
                chip.content[first : first + len(old)] = whole
                chip.under_way, chip.busy_until_us = under_way, until_us


@pytest.fixture(scope="module")
def saved_everywhere() -> Chip:
    """Return a chip with a record in each sector, so that the next record replaces record 1.

    The records contain the coefficients of one turn.
    """
    board = Board(Chip("n25q128"))
    board.firmware.send("set orders 3")
    board.work(range(1, 3))
    for number in range(1, SECTORS + 1):
        assert board.order("save").startswith(f"ok, record {number}: ")
    assert board.chip.erased == places_of(board.chip)
    return board.chip


def copy_of(chip: Chip) -> Chip:
    copy = Chip("n25q128")
    copy.content[:] = chip.content
    return copy


def found_in(chip: Chip) -> int | None:
    return Memory(memoryview(chip.content)[REGION.start : REGION.stop], chip.sector).found()


def record_at(chip: Chip, place: int) -> bytes:
    return bytes(chip.content[place : place + RECORD_BYTES])


@pytest.mark.large
@pytest.mark.parametrize(
    "wear",
    [
        "",
        "erase",
        "program",
    ],
)
def test_a_save_that_is_cut_off_anywhere_leaves_the_record_before(
    saved_everywhere: Chip, wear: str
) -> None:
    """The new record counts only if all its bytes were written.

    With a worn sector, power is also lost in the failed write and in the next write.
    """
    board = Board(copy_of(saved_everywhere))
    first, second = places_of(board.chip)[:2]
    board.chip.worn = {first: wear} if wear else {}
    place = second if wear else first
    board.firmware.send("set keep 0.5")
    seen: list[tuple[str, int | None, bytes]] = []
    torn = Torn(
        board.chip,
        lambda at: seen.append((at, found_in(board.chip), record_at(board.chip, place))),
        every_byte=1024,
    )
    saved = SECTORS + (2 if wear else 1)
    assert board.order("save").startswith(f"ok, record {saved}")
    whole = record_at(board.chip, place)
    assert len(whole.rstrip(b"\xff")) < 1024, "every byte of the record was tried"
    assert torn.cuts > 3 * len(whole.rstrip(b"\xff"))
    for at, number, content in seen:
        assert number == (saved if content == whole else SECTORS), at


@pytest.mark.parametrize(
    "write", [0, *(pytest.param(n, marks=pytest.mark.large) for n in (1, 2, 3))]
)
@pytest.mark.parametrize(
    "order",
    [
        pytest.param("up", marks=pytest.mark.large),
        pytest.param("down", marks=pytest.mark.large),
        "none",
    ],
)
def test_the_board_comes_up_and_saves_again(saved_everywhere: Chip, write: int, order: str) -> None:
    """After a power loss in the middle of the erase, or of one of three pages, the whole firmware
    starts with this flash and saves again."""
    chip = copy_of(saved_everywhere)
    board = Board(chip)
    before = int(board.status("saved_record")[0])
    board.firmware.send("set keep 0.5")
    board.firmware.send("save")
    for _ in range(STEPS_MOST):
        if len(chip.erased) + len(chip.programmed) == write + 1:
            break
        board.controller.now_us += 10_000
        board.firmware.step()
    assert chip.under_way is not None
    chip.lose_power(min(100, len(chip.under_way[1]) // 2), np.random.default_rng(write), order)
    board.power_on()
    assert board.status("saved_record") == [str(before)]
    assert board.status("saved") == ["waiting"]
    assert board.firmware.turn(turn(seed=9))["result"] == "applied"
    assert board.status("saved") == ["confirmed"]
    assert board.order("save").startswith(f"ok, record {before + 1}: ")
    board.power_on()
    assert board.status("saved_record") == [str(before + 1)]


def test_an_image_that_is_cut_off_anywhere_leaves_one_that_starts() -> None:
    """After a power loss anywhere in the writing of an image, an image starts; a complete header
    with an incomplete body would start bytes that are no program."""
    board = test_image_store.Board(Chip())
    write_image(board, boot_image(OLD, 0), silent)
    seen: list[tuple[str, tuple[int, bytes] | None]] = []
    # Every byte of the header is tried, because the boot ROM reads it; all bytes of the body are
    # equivalent.
    torn = Torn(board.chip, lambda at: seen.append((at, starts(board.chip))), 0x60)
    write_image(board, boot_image(NEW, 0), silent)
    assert torn.cuts > 3 * len(NEW)
    good = {(GOLDEN, program(OLD)), (0, program(NEW))}
    assert [at for at, image in seen if image not in good] == []
    assert {image for _, image in seen} == good
    assert struct.unpack_from("<I", board.chip.content, 0x24)[0] == 0x584C4E58
