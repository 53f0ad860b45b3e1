"""Models a serial flash and the controller of the Zynq that reaches the flash.

The models are written from UG585 (quad-SPI controller, I/O mode) and the data sheets of S25FL128S,
N25Q128 and W25Q128, not from the C code: only the register addresses come from its header
zynq/registers.h.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Any

import numpy as np
from sim.tests.firmware.library import firmware
from sim.tests.firmware.pin_model import Pins
from sim.tests.firmware.zynq_model import (
    AT,
    QSPI_LEFT,
    QSPI_LINEAR,
    QSPI_MOST_MHZ,
    QSPI_REFERENCE_MHZ,
)

CHIPS = {
    "s25fl128s_256k": (bytes.fromhex("0120184d0080"), 256 << 10),
    "s25fl128s_64k": (bytes.fromhex("0120184d0180"), 64 << 10),
    "n25q128": (bytes.fromhex("20ba18100000"), 64 << 10),
    "w25q128": (bytes.fromhex("ef4018ef4018"), 64 << 10),
}
"""JEDEC ID of each chip, and number of bytes that its command D8h erases. The IDs come from the
table "device ID" of S25FL128S and from "RDID" of N25Q128 and W25Q128."""
FLASH_BYTES = 16 << 20
PAGE_BYTES = 256
WORKS, ENABLED, ERASE_FAILED, PROGRAM_FAILED = 1, 2, 1 << 5, 1 << 6
"""Status bits. After ERASE_FAILED or PROGRAM_FAILED a Spansion flash stays busy until the command
30h clears the bit."""
NOT_SELECTED, MANUAL_SELECT, MANUAL_START, START = 1 << 10, 1 << 14, 1 << 15, 1 << 16
RECEIVED = 1 << 4
READ_US = 1
ERASE_US, PROGRAM_US = 520_000, 750


class Chip:
    """A flash chip: programming clears bits, and erasing sets the bits of a sector.

    ``fault`` names a fault: silent, silent_after_id (the chip answers reads of ID and status; from
    the second byte of any other command on it is silent), stuck (an operation never ends),
    protected (nothing is erased or programmed), or bad_bit (programming inverts one bit).

    ``worn`` maps the address of a sector to the operation that fails there, ``erase`` or
    ``program``.

    The model keeps the address and the former content of the last write, so that ``lose_power`` can
    end this write anywhere.
    """

    def __init__(self, kind: str = "s25fl128s_256k", fault: str = "") -> None:
        self.id, self.sector = CHIPS[kind]
        self.content = bytearray(b"\xff" * FLASH_BYTES)
        self.fault = fault
        self.worn: dict[int, str] = {}
        self.failed = 0
        self.enabled = False
        self.busy_until_us = 0.0
        self.received = bytearray()
        self.erased: list[int] = []
        self.programmed: list[tuple[int, bytes]] = []
        self.under_way: tuple[int, bytes] | None = None

    def lose_power(self, done: int, draw: np.random.Generator, order: str = "up") -> None:
        """Undo the last write as if the power had failed at its byte ``done``: each bit of this
        byte that the write would change has, at random, its old or its new value.

        ``order``: with "up" the bytes before ``done`` are written and those after it are unchanged;
        with "down" it is the opposite; with "none" every byte of the write is random in this way.
        An erase may leave any bits, because most flashes program a sector to 0 before they erase
        it.
        """
        assert self.under_way is not None, "nothing is written"
        first, old = self.under_way
        before = np.frombuffer(old, dtype=np.uint8)
        after = np.frombuffer(bytes(self.content[first : first + len(old)]), dtype=np.uint8)
        if order == "none":
            left, torn = before.copy(), slice(0, len(old))
        elif order == "up":
            left, torn = np.concatenate([after[:done], before[done:]]), slice(done, done + 1)
        else:
            left, torn = np.concatenate([before[:done], after[done:]]), slice(done, done + 1)
        drawn = draw.integers(0, 256, len(left[torn]), dtype=np.uint8)
        erases = len(old) > PAGE_BYTES
        left[torn] = drawn if erases else before[torn] ^ (before ^ after)[torn] & drawn
        self.content[first : first + len(old)] = left.tobytes()
        self.under_way = None
        self.enabled = False
        self.busy_until_us = 0.0

    def select(self) -> None:
        self.received.clear()

    def exchange(self, byte: int, now_us: int) -> int:
        """Take one byte and return the byte that the chip sends in the clocks of this byte."""
        place = len(self.received)
        self.received.append(byte)
        command = self.received[0]
        working = now_us < self.busy_until_us
        if self.fault == "silent" or place == 0:
            return 0xFF
        if command == 0x05:
            failed = 0 if working else self.failed
            works = WORKS if working or failed else 0
            return works | (ENABLED if self.enabled else 0) | failed
        working = working or bool(self.failed)
        assert not working, f"{command:#x} while something is under way"
        if command != 0x9F and self.fault == "silent_after_id":
            self.fault = "silent"
            return 0xFF
        if command == 0x9F:
            return self.id[place - 1] if place <= len(self.id) else 0
        if command == 0x03 and place >= 4:
            return self.content[(self.address() + place - 4) % FLASH_BYTES]
        return 0xFF

    def address(self) -> int:
        return int.from_bytes(self.received[1:4], "big")

    def deselect(self, now_us: int) -> None:
        """Release the select line, which starts the write."""
        command = self.received[0] if self.received else None
        if command == 0x06 and len(self.received) == 1:
            self.enabled = True
        elif command == 0xD8 and len(self.received) == 4:
            self.erase(now_us)
        elif command == 0x02:
            self.program(now_us)
        elif command == 0x30:
            self.failed = 0
        else:
            assert command in (None, 0x03, 0x05, 0x9F), self.received.hex()
        self.received.clear()

    def erase(self, now_us: int) -> None:
        assert self.enabled, "no write enable"
        first = self.address() // self.sector * self.sector
        self.under_way = first, bytes(self.content[first : first + self.sector])
        if self.worn.get(first) == "erase":
            self.fail(ERASE_FAILED)
            self.content[first : first + self.sector : 3] = bytes(len(range(0, self.sector, 3)))
        elif self.fault != "protected":
            self.content[first : first + self.sector] = b"\xff" * self.sector
        self.erased.append(first)
        self.finish(now_us + ERASE_US)

    def program(self, now_us: int) -> None:
        assert self.enabled, "no write enable"
        address, data = self.address(), bytes(self.received[4:])
        assert address % PAGE_BYTES + len(data) <= PAGE_BYTES, "it would wrap within the page"
        self.under_way = address, bytes(self.content[address : address + len(data)])
        for place, byte in enumerate(data, start=address):
            if self.fault != "protected":
                self.content[place] &= byte
        worn = self.worn.get(address // self.sector * self.sector) == "program"
        if worn:
            self.fail(PROGRAM_FAILED)
        if self.fault == "bad_bit" or worn:
            bad = min(8, len(data) - 1)
            self.content[address + bad] ^= 1
        self.programmed.append((address, data))
        self.finish(now_us + PROGRAM_US)

    def fail(self, bit: int) -> None:
        """Set a failure bit, which S25FL128S has in status register 1 and other flashes have in
        another register."""
        self.failed = bit if self.id[0] == 0x01 else 0

    def finish(self, until_us: int) -> None:
        self.enabled = False
        self.busy_until_us = math.inf if self.fault == "stuck" else until_us


class Controller:
    """The controller, with its registers and the connected flash chip. The C code reads and writes
    the registers through ``access``."""

    def __init__(self, chip: Chip, fault: str = "") -> None:
        self.chip = chip
        self.pins = Pins()
        self.fault = fault
        self.now_us = 0
        self.words = {AT["QSPI_CONFIG"]: QSPI_LEFT, AT["QSPI_LQSPI_CFG"]: 0x8000_010B}
        self.queue: deque[int] = deque([0xDEAD_BEEF] * 3)
        self.selected = False
        ffi, _ = firmware()
        self._calls = (
            ffi.callback("register_access_read", self.read),
            ffi.callback("register_access_write", self.write),
            ffi.callback("register_access_microseconds", lambda _: self.now_us & 0xFFFF_FFFF),
        )
        self.access = ffi.new("struct register_access *", list(self._calls))

    def read(self, _: Any, address: int) -> int:
        self.now_us += READ_US
        if address == AT["QSPI_STATUS"]:
            return RECEIVED if len(self.queue) >= self.words[AT["QSPI_RX_THRESHOLD"]] else 0
        if address == AT["QSPI_RXD"]:
            return self.queue.popleft()
        return self.words.get(address, 0)

    def write(self, _: Any, address: int, word: int) -> None:
        if address in (AT["QSPI_TXD0"], AT["QSPI_TXD1"]):
            self.send(word, 4 if address == AT["QSPI_TXD0"] else 1)
            return
        self.words[address] = word
        self.pins.write(address, word)
        if address == AT["QSPI_CONFIG"]:
            assert word & MANUAL_SELECT, (
                "the controller would release the select line between two words"
            )
            self.follow_select(selected=not word & NOT_SELECTED)

    def follow_select(self, *, selected: bool) -> None:
        if self.pins.reach_the_flash():
            if selected and not self.selected:
                self.chip.select()
            elif self.selected and not selected:
                self.chip.deselect(self.now_us)
        self.selected = selected

    def send(self, word: int, number: int) -> None:
        config = self.words[AT["QSPI_CONFIG"]]
        assert self.selected
        assert self.words[AT["QSPI_EN"]] == 1
        assert not self.words[AT["QSPI_LQSPI_CFG"]] >> 31, "linear mode"
        assert config & QSPI_LINEAR == QSPI_LINEAR
        assert not config & (MANUAL_START | START)
        assert QSPI_REFERENCE_MHZ / (2 << (config >> 3 & 7)) <= QSPI_MOST_MHZ
        sent = word.to_bytes(4, "little")[:number]
        # A wire that no chip drives is pulled up.
        answer = b"\xff" * number
        if self.pins.reach_the_flash():
            answer = bytes(self.chip.exchange(byte, self.now_us) for byte in sent)
        if self.fault != "silent":
            # If fewer than four bytes arrive, they are the upper bytes of the word.
            self.queue.append(int.from_bytes(answer.rjust(4, b"\0"), "little"))
