"""Tests that boot images can be written to the flash over the console, and that one of them starts
after a power loss at any moment."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable

import pytest
from sim.tests.firmware.flash_model import FLASH_BYTES, Chip, Controller
from sim.tests.firmware.library import firmware as c_library
from sim.tests.firmware.model_core import Firmware, ModelCore

from arctrue.device import flash as device
from arctrue.device.console import ConsoleError
from arctrue.device.flash import FlashRefusedError, lines_of, parts_of, write_image
from scripts.image import boot_image, fabric_image, flash_image, flash_map

OLD, NEW = bytes(range(256)) * 3, bytes(reversed(range(256))) * 4
SYNC = bytes.fromhex("aa995566")
STEPS_MOST = 1000


class Board:
    """Board with a flash and the firmware's C code; its console takes the place of a serial
    port."""

    port = "board"

    def __init__(self, chip: Chip) -> None:
        ffi, library = c_library()
        self.chip = chip
        chip.busy_until_us = 0.0
        self.controller = Controller(chip)
        self.firmware = Firmware(ModelCore())
        self.flash = ffi.new("struct flash *")
        library.flash_prepare(self.flash, self.controller.access)
        access = ffi.new("struct flash_access *", library.flash_access_to(self.flash))
        places = flash_map()
        golden = places["GOLDEN"], places["GOLDEN_BYTES"], places["RECORDS"]
        self.map = ffi.new("struct image_map *", golden)
        self.store = ffi.new("struct image_store *")
        library.image_store_prepare(self.store, access, self.map)
        self.firmware.console.images = self.store
        self.after_line: Callable[[], None] = lambda: None
        self.spoil = 0

    def close(self) -> None:
        """Do nothing, unlike a real console, which would close its port."""

    def command(self, line: str, _seconds: float = 5.0) -> list[str]:
        if self.spoil and line.startswith("flash data"):
            self.spoil -= 1
            line = line.replace("FF", "FE", 1) if "FF" in line else line[:-1] + "G"
        said = self.firmware.send(line)
        for _ in range(STEPS_MOST):
            if said:
                break
            self.controller.now_us += 10_000
            said = self.firmware.step()
        self.after_line()
        answer = said.splitlines()
        assert answer, f"no answer to {line}"
        if answer[-1].startswith("error"):
            raise ConsoleError(f"{self.port}: {line}: the device says {answer[-1]}")
        return answer[:-1] if answer[-1].startswith("ok") else answer


def starts(chip: Chip) -> tuple[int, bytes] | None:
    """Return the program that the boot ROM would start and the address of its image in the flash,
    address first; the rules are those of UG585, chapter 6, without the C code."""
    for place in range(0, FLASH_BYTES, 32 << 10):
        header = bytes(chip.content[place : place + 0x4C])
        words = struct.unpack("<11I", header[0x20:0x4C])
        if header[0x20:0x28] != bytes.fromhex("665599aa584e4c58")[:4] + b"XNLX":
            continue
        if words[-1] != ~sum(words[:-1]) & 0xFFFF_FFFF:
            continue
        offset, length = words[4], words[5]
        return place, bytes(chip.content[place + offset : place + offset + length])
    return None


def program(body: bytes) -> bytes:
    return body.ljust(-(-len(body) // 64) * 64, b"\xff")


def silent(_done: int, _all: int) -> None:
    pass


@pytest.mark.parametrize("kind", ["s25fl128s_256k", "n25q128"])
def test_the_first_image_is_golden_too(kind: str) -> None:
    """An image written into an empty flash becomes the golden copy too; both images and the
    bitstream in the flash have exactly the bytes that were made."""
    board = Board(Chip(kind))
    image = flash_image(OLD, 0, bytes(64) + SYNC + OLD, "made here")
    assert not write_image(board, image, silent).has_golden
    assert starts(board.chip) == (0, program(OLD))
    places = flash_map()
    boot = boot_image(OLD, 0)
    assert bytes(board.chip.content[places["GOLDEN"] :][: len(boot)]) == boot
    fabric = fabric_image(bytes(64) + SYNC + OLD, "made here")
    assert bytes(board.chip.content[places["BITSTREAM"] :][: len(fabric)]) == fabric


def test_power_lost_at_any_line_leaves_an_image_that_starts() -> None:
    """If power is lost after any line of the console, an image still starts, also when the last
    page is only half written."""
    board = Board(Chip())
    write_image(board, boot_image(OLD, 0), silent)
    golden = bytes(board.chip.content[device.GOLDEN : 2 * device.GOLDEN])
    seen = []
    board.after_line = lambda: seen.append(starts(board.chip))
    write_image(board, boot_image(NEW, 0), silent)
    assert set(seen) == {(0, program(OLD)), (device.GOLDEN, program(OLD)), (0, program(NEW))}
    # The first line only requests the status. Then the old image is erased at once. The new image
    # is complete after the line with the checksum; one more line, for the comparison, follows.
    assert seen.index((0, program(NEW))) == len(seen) - 2
    assert bytes(board.chip.content[device.GOLDEN : 2 * device.GOLDEN]) == golden


def test_the_golden_image_and_what_is_saved_cannot_be_written() -> None:
    board = Board(Chip())
    write_image(board, boot_image(OLD, 0), silent)
    before = bytes(board.chip.content)
    line = next(lines_of(b"\0" * 24, device.GOLDEN + 0x1_0000))
    for refused, reason in (
        (line, "golden_stays"),
        (f"flash erase {device.GOLDEN:X}", "golden_stays"),
        (f"flash erase {device.END:X}", "wrong_place"),
        (next(lines_of(b"\0" * 4, device.END)), "wrong_place"),
        (next(lines_of(b"\0" * 4, 0x9_0002)), "wrong_place"),
        (f"flash check {device.END - 4:X} 8", "wrong_place"),
        ("flash check 0 3", "wrong_place"),
        ("flash data 0 1234567 0", "wrong_crc"),
        ("flash data 0 0000000X 0", "wrong_crc"),
        ("flash erase nowhere", "use: flash status"),
    ):
        with pytest.raises(ConsoleError, match=reason):
            board.command(refused)
    words = struct.pack("<2I", 1, 2)
    crc = zlib.crc32(struct.pack("<I", 0xFC) + words)
    with pytest.raises(ConsoleError, match="wrong_place"):
        board.command(f"flash data FC 0000000100000002 {crc:08X}")
    assert bytes(board.chip.content) == before


@pytest.mark.parametrize(
    ("fault", "reason"),
    [("stuck", "flash_stuck"), ("bad_bit", "flash_not_read_back"), ("silent", "does not support")],
)
def test_a_flash_that_does_not_obey(fault: str, reason: str) -> None:
    board = Board(Chip(fault=fault))
    with pytest.raises(FlashRefusedError, match=reason):
        write_image(board, boot_image(OLD, 0), silent)


def test_a_spoiled_line_is_sent_again() -> None:
    board = Board(Chip())
    board.spoil = device.ATTEMPTS - 1
    write_image(board, boot_image(OLD, 0), silent)
    assert starts(board.chip) == (0, program(OLD))
    board.spoil = device.ATTEMPTS
    with pytest.raises(FlashRefusedError, match="wrong_crc"):
        write_image(board, boot_image(NEW, 0), silent)


def test_status_tells_where_the_image_was_found() -> None:
    board = Board(Chip())
    board.firmware.console.started_from = 0x4_0000
    write_image(board, boot_image(OLD, 0), silent)
    assert board.command("flash status") == [
        "golden whole",
        "sector_bytes 262144",
        "started_from 0x00040000",
    ]


def test_status_during_an_operation_makes_no_statement_about_the_golden_image() -> None:
    """The flash cannot be read while it erases. If ``flash status`` called an intact golden image
    missing, ``arctrue flash`` would try to write it again."""
    board = Board(Chip())
    write_image(board, boot_image(OLD, 0), silent)
    assert board.firmware.send("flash erase 0") == ""
    assert board.firmware.send("flash status") == "error: flash under_way\r\n"
    with pytest.raises(FlashRefusedError, match="under_way"):
        device.state_of(board)
    board.controller.now_us += 10_000_000
    assert board.firmware.step() == "ok\r\n"
    assert device.state_of(board).has_golden


def test_a_flash_that_cannot_be_read_is_not_taken_for_one_without_golden_image() -> None:
    """If the controller fails to read the golden header once, nothing is erased there, and the
    status names the failure; an earlier firmware allowed the erase."""
    board = Board(Chip())
    write_image(board, boot_image(OLD, 0), silent)
    before = bytes(board.chip.content)
    ffi, _ = c_library()
    fails = ffi.callback("flash_access_read", lambda *_: False)
    board.store.flash.read = fails
    for line in (f"flash erase {device.GOLDEN:X}", "flash status"):
        with pytest.raises(ConsoleError, match="flash flash_silent"):
            board.command(line)
    assert bytes(board.chip.content) == before


def test_saving_and_flashing_do_not_meet() -> None:
    """The firmware refuses ``save`` while an erase is running. A firmware without a flash answers
    ``flash status`` with an error."""
    board = Board(Chip())
    board.firmware.send("flash erase 0")
    assert "under_way" in board.firmware.send("save")
    bare = Firmware(ModelCore())
    assert bare.send("flash status") == "error: flash flash_unknown\r\n"


def test_what_is_no_image_is_refused() -> None:
    with pytest.raises(FlashRefusedError, match=r"make image"):
        parts_of(b"\xff" * 10_000)
    with pytest.raises(FlashRefusedError, match="bytes"):
        parts_of(boot_image(OLD, 0).ljust(device.END + 4, b"\0"))
    boot, fabric = parts_of(flash_image(OLD, 0, None))
    assert boot == boot_image(OLD, 0).rstrip(b"\xff")
    assert fabric == b""
