"""Tests the boot image with a model of the boot ROM, which shares no code with the program that
writes the image."""

from __future__ import annotations

import struct
import subprocess
import sys
from pathlib import Path

import pytest
from sim.tests.firmware.emulator import build
from sim.tests.firmware.library import ROOT, firmware
from sim.tests.firmware.zynq_model import ZynqModel

from scripts.image import ImageError, boot_image, fabric_image, flash_image, flash_map, program_of
from scripts.tests.flash.empty_chip import empty_chip

FABRIC_OFFSET = 0x10_0000
SYNC = bytes.fromhex("aa995566")


def boot_rom(flash: bytes) -> tuple[int, bytes, int]:
    """Read the BootROM header word by word as in UG585; return load address, body and start
    address."""

    def word(address: int) -> int:
        return int.from_bytes(flash[address : address + 4], "little")

    assert flash[0x20:0x24] == bytes.fromhex("665599aa")
    assert flash[0x24:0x28] == b"XNLX"
    assert word(0x28) == 0, "not encrypted"
    total = 0
    for address in range(0x20, 0x48, 4):
        total += word(address)
    assert (total + word(0x48)) % (1 << 32) == 0xFFFF_FFFF
    for address in range(0xA0, 0x8A0, 8):
        assert word(address) == 0xFFFF_FFFF, "the first pair like this ends the table"
    source, length, load, start = (word(address) for address in (0x30, 0x34, 0x38, 0x3C))
    assert source % 64 == 0
    assert source >= 0x8C0
    assert 0 < length <= 0x30000
    assert length == word(0x40)
    # U-Boot's program mkimage -T zynqimage (2023.01) also checks these words.
    assert start % 64 == 0
    assert word(0x38) == 0
    assert word(0x44) == 0
    return load, flash[source : source + length], start


def bit_file(body: bytes) -> bytes:
    """Return a .bit in the form that the tools write: tagged text of odd length, dummy words,
    body."""
    head = bytes.fromhex("00090ff00ff00ff00ff0000001")
    head += b"a\x00\x05top;\x00" + b"e" + struct.pack(">I", 48 + len(body))
    return head + b"\xff" * 32 + bytes.fromhex("000000bb11220044") + b"\xff" * 8 + body


def test_what_the_boot_rom_loads_starts_and_speaks(tmp_path: Path) -> None:
    elf = build()
    program, entry = program_of(elf)
    load, body, start = boot_rom(flash_image(program, entry, None)[: flash_map()["GOLDEN"]])
    assert body.startswith(program)
    (tmp_path / "memory.bin").write_bytes(body)
    memory = f"loader,file={tmp_path}/memory.bin,addr={load:#x},force-raw=on"
    begin = f"loader,addr={start:#x},cpu-num=0"
    with empty_chip(tmp_path, "-device", memory, "-device", begin) as chip:
        chip.wait_for(b"arctrue pynq_z2, help lists the commands")


def test_the_firmware_finds_and_loads_the_bitstream() -> None:
    body = SYNC + bytes(range(256)) * 3
    flash = flash_image(b"\0" * 64, 0, bit_file(body), "top.bit")
    model = ZynqModel(flash[FABRIC_OFFSET:])
    ffi, library = firmware()
    fabric = ffi.new("struct fabric *")
    library.fabric_prepare(fabric, model.access)
    while library.fabric_step(fabric):
        pass
    assert ffi.string(library.fabric_state_name(fabric.state)) == b"loaded"
    # The configuration port reads words (UG585); the most significant byte of each word is the
    # first of its four bytes in the .bit.
    received = bytes(model.received)
    swapped = b"".join(received[place : place + 4][::-1] for place in range(0, len(received), 4))
    assert swapped[:48] == b"\xff" * 32 + bytes.fromhex("000000bb11220044") + b"\xff" * 8
    assert swapped[48:] == body


def test_a_raw_bitstream_gets_the_words_before_the_sync_word() -> None:
    """A raw bitstream gets the words before the sync word: after the header of 64 bytes, 48 bytes
    precede the sync word."""
    image = fabric_image(SYNC + bytes(60), "raw.bin")
    assert image[64 : 64 + 48] == b"\xff" * 48
    assert image[64 + 48 : 64 + 52] == SYNC[::-1]


def test_a_file_without_sync_word_is_refused() -> None:
    with pytest.raises(ImageError, match=r"other\.bin: no sync word"):
        fabric_image(bytes(5000), "other.bin")


def test_a_program_that_does_not_fit_is_refused() -> None:
    with pytest.raises(ImageError, match="196,672 bytes; the boot ROM takes 196,608"):
        boot_image(bytes(192 * 1024 + 1), 0)
    with pytest.raises(ImageError, match="starts at 0x40, outside its 64 bytes"):
        boot_image(bytes(64), 64)
    with pytest.raises(ImageError, match="starts at 0x20, not a multiple of 64"):
        boot_image(bytes(64), 0x20)


def test_the_command_says_what_is_missing(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "scripts.image", str(tmp_path / "none.elf"), "--out", "x"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    expected = f"error: {tmp_path}/none.elf: there is no such file; make firmware makes it\n"
    assert done.stderr == expected
