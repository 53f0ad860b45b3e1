"""Tests the driver of the serial flash through the controller's registers; the models are written
from the data sheets."""

from __future__ import annotations

from typing import Any

import pytest
from sim.tests.firmware.flash_model import CHIPS, ERASE_US, Chip, Controller
from sim.tests.firmware.library import firmware
from sim.tests.firmware.pin_model import QSPI_PINS, pin_address
from sim.tests.firmware.zynq_model import AT

RECORD = 0xF0_0000


def opened(controller: Controller) -> tuple[Any, int]:
    """Open the flash; return the driver and the number of bytes in a sector."""
    ffi, library = firmware()
    flash = ffi.new("struct flash *")
    library.flash_prepare(flash, controller.access)
    return flash, library.flash_open(flash)


def words_of(flash: Any, address: int, number: int) -> list[int]:
    ffi, library = firmware()
    words = ffi.new("uint32_t[]", number)
    assert library.flash_read(flash, address, words, number)
    return list(words)


def wait(controller: Controller, flash: Any) -> int:
    """Wait until the flash is idle, and return the elapsed microseconds."""
    _, library = firmware()
    start = controller.now_us
    while (activity := library.flash_activity(flash)) == library.FLASH_AT_WORK:
        controller.now_us += 1000
    assert activity == library.FLASH_IDLE
    return controller.now_us - start


@pytest.mark.parametrize("kind", CHIPS)
def test_a_sector_is_erased_and_a_page_programmed(kind: str) -> None:
    _, library = firmware()
    ffi, _ = firmware()
    chip = Chip(kind)
    controller = Controller(chip)
    chip.content[RECORD - 4 : RECORD + chip.sector + 4] = bytes(chip.sector + 8)
    flash, sector = opened(controller)
    assert (sector, flash.id) == (chip.sector, int.from_bytes(chip.id[:3], "big"))
    assert library.flash_erase(flash, RECORD)
    assert wait(controller, flash) >= ERASE_US
    assert words_of(flash, RECORD - 4, 2) == [0, 0xFFFF_FFFF]
    assert words_of(flash, RECORD + sector - 4, 2) == [0xFFFF_FFFF, 0]
    page = [0x9E37_79B9 * i & 0xFFFF_FFFF for i in range(64)]
    assert library.flash_program(flash, RECORD + 256, ffi.new("uint32_t[]", page), 64)
    wait(controller, flash)
    assert words_of(flash, RECORD + 256, 64) == page
    first = chip.content[RECORD + 256 : RECORD + 260]
    assert first == page[0].to_bytes(4, "little"), "the lower byte first, as linear reading has it"
    assert words_of(flash, RECORD + 252, 1) == [0xFFFF_FFFF]


def test_a_chip_that_is_not_known_is_not_written() -> None:
    chip = Chip()
    chip.id = bytes.fromhex("1f4700000000")
    flash, sector = opened(Controller(chip))
    assert (sector, flash.id) == (0, 0x1F4700)


@pytest.mark.parametrize("where", ["chip", "controller"])
def test_what_does_not_answer(where: str) -> None:
    silent = Chip(fault="silent" if where == "chip" else "")
    controller = Controller(silent, fault="silent" if where == "controller" else "")
    flash, sector = opened(controller)
    assert sector == 0
    ffi, library = firmware()
    words = ffi.new("uint32_t[]", 1)
    assert library.flash_read(flash, 0, words, 1) == (where == "chip")
    assert controller.now_us < 1_000_000


def test_what_does_not_end() -> None:
    _, library = firmware()
    controller = Controller(Chip(fault="stuck"))
    flash, _ = opened(controller)
    assert library.flash_erase(flash, RECORD)
    while (activity := library.flash_activity(flash)) == library.FLASH_AT_WORK:
        controller.now_us += 100_000
    assert activity == library.FLASH_STUCK
    assert 3_000_000 < controller.now_us < 10_000_000, "the longest of the data sheets is 3 s"


def test_linear_reading_afterwards_finds_what_it_needs() -> None:
    """After the driver has opened the flash, the linear mode and the loop-back delay are off.
    fabric.c, which reads the flash in the linear mode, sets the bits that it needs."""
    controller = Controller(Chip())
    opened(controller)
    assert controller.words[AT["QSPI_LQSPI_CFG"]] >> 31 == 0
    assert controller.words[AT["QSPI_LPBK_DLY_ADJ"]] == 0


def test_the_flash_is_reached_without_the_boot_rom() -> None:
    """The driver reaches the flash after `make flash` over JTAG, when the boot ROM has not
    connected the controller to the pins."""
    controller = Controller(Chip())
    _, sector = opened(controller)
    assert sector == controller.chip.sector
    assert {pin: controller.words[pin_address(pin)] for pin in QSPI_PINS} == {
        1: 0x1602,
        **dict.fromkeys(range(2, 7), 0x0602),
    }, "LVCMOS33; a pull-up at the select line"


@pytest.mark.parametrize("word", [0x0601, 0x0202, 0x0402, 0x0603, 0x0600, 0x06E2])
@pytest.mark.parametrize("pin", QSPI_PINS)
def test_a_pin_that_is_not_the_flashs(pin: int, word: int) -> None:
    """The model rejects each of these states of a pin: no function, 1.8 V, 2.5 V, not driven,
    general purpose, another device."""
    controller = Controller(Chip())
    flash, _ = opened(controller)
    controller.pins.words[pin] = word
    _, library = firmware()
    assert library.flash_open(flash) == 0
