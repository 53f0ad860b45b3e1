"""Tests ``make flash`` with an emulated processor, and ``make flash-bitstream`` with a simulated
scan chain."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from sim.tests.firmware.emulator import build

from scripts.flash import ONBOARD_ADAPTER, FlashError, load_bitstream, load_firmware
from scripts.tests.flash.empty_chip import empty_chip
from scripts.tests.flash.jtag_chain import CFG_IN, JPROGRAM, Adapter, Chain

needs_gdb = pytest.mark.skipif(
    shutil.which("gdb-multiarch") is None, reason="gdb-multiarch is not installed"
)
needs_openocd = pytest.mark.skipif(
    shutil.which("openocd") is None, reason="openocd is not installed"
)


@needs_gdb
def test_the_firmware_is_loaded_compared_and_speaks(tmp_path: Path) -> None:
    """``make flash`` loads, compares and starts the firmware; QEMU starts stopped and without a
    program, and its gdb port takes the place of a board's adapter."""
    elf = build()
    with empty_chip(tmp_path, "-S") as chip:
        size, sections = load_firmware(elf, ONBOARD_ADAPTER, str(chip.debugger))
        assert size > 10_000
        assert sections >= 2
        chip.wait_for(b"arctrue pynq_z2, help lists the commands")


@needs_gdb
def test_nothing_at_the_port_is_said(tmp_path: Path) -> None:
    elf = build()
    with pytest.raises(FlashError, match=r"nothing was loaded|gave up"):
        load_firmware(elf, ONBOARD_ADAPTER, str(tmp_path / "nobody"), 20.0)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FlashError, match=r"none\.bit: there is no such file; make bitstream"):
        load_bitstream(tmp_path / "none.bit", ONBOARD_ADAPTER)


def adapter_file(folder: Path, port: int) -> Path:
    path = folder / "simulated.cfg"
    path.write_text(
        "adapter driver remote_bitbang\n"
        f"remote_bitbang port {port}\nremote_bitbang host 127.0.0.1\n"
        "transport select jtag\nadapter speed 1000\n"
    )
    return path


def bit_file(folder: Path, words: bytes) -> Path:
    """Write a .bit file: a header of tagged fields in Xilinx' form, then the words."""
    head = bytes.fromhex("0009 0ff00ff00ff00ff000 0001")
    for tag, text in zip("abcd", ("top", "7z020clg400", "2026/11/21", "00:00:00"), strict=True):
        field = text.encode() + b"\0"
        head += tag.encode() + len(field).to_bytes(2, "big") + field
    path = folder / "arctrue.bit"
    path.write_bytes(head + b"e" + len(words).to_bytes(4, "big") + words)
    return path


@needs_openocd
def test_the_bitstream_reaches_the_fabric_bit_by_bit(tmp_path: Path) -> None:
    words = bytes.fromhex("ffffffffaa995566") + bytes(range(256))
    chain = Chain()
    adapter = Adapter(chain)
    load_bitstream(bit_file(tmp_path, words), adapter_file(tmp_path, adapter.port), 60.0)
    adapter.wait()
    given = chain.fabric.instructions
    assert given.index(JPROGRAM) < given.index(CFG_IN)
    # The most significant bit of each byte comes first (UG470).
    sent = [byte >> place & 1 for byte in words for place in range(7, -1, -1)]
    longest = max(chain.configuration, key=len)
    assert "".join(map(str, sent)) in "".join(map(str, longest))


@needs_openocd
def test_another_chip_is_refused(tmp_path: Path) -> None:
    chain = Chain(fabric_idcode=0x1362_C093)
    adapter = Adapter(chain)
    bitstream = bit_file(tmp_path, bytes(64))
    with pytest.raises(FlashError, match="is it an XC7Z020"):
        load_bitstream(bitstream, adapter_file(tmp_path, adapter.port), 60.0)
    adapter.wait()
    assert JPROGRAM not in chain.fabric.instructions


@needs_openocd
def test_the_files_for_the_board_are_read_by_openocd() -> None:
    """OpenOCD reads the files for the board without an error until it searches for the adapter,
    which is missing here."""
    for name in ("processor.cfg", "fabric.cfg"):
        command = ["openocd", "-f", str(ONBOARD_ADAPTER), "-f", str(ONBOARD_ADAPTER.parent / name)]
        command += ["-c", "gdb_port disabled; telnet_port disabled; tcl_port disabled"]
        command += ["-c", "init; shutdown"]
        done = subprocess.run(
            command,
            capture_output=True,
            text=True,
            check=False,
            timeout=60,
        )
        assert "unable to open ftdi device" in done.stderr, done.stderr
