"""Models the Zynq registers that load the fabric and read its temperature.

The model is written from UG585 (device configuration interface, PS-XADC) and UG480, not from the C
code: only the register addresses come from its header zynq/registers.h.
"""

from __future__ import annotations

import re
import struct
import zlib
from collections import deque
from typing import Any

from sim.tests.firmware.library import FIRMWARE, firmware

SYNC_WORD = 0xAA995566
FLASH = 0xFC00_0000
IMAGE_OFFSET = 0x10_0000
UNLOCK_KEYS = {"SLCR_UNLOCK": 0xDF0D, "DEVC_UNLOCK": 0x757BDF0D}
READ_US = 5
PROG_B, LOOPBACK = 1 << 30, 1 << 4
INIT, QUEUE_EMPTY, QUEUE_FULL = 1 << 4, 1 << 30, 1 << 31
CONFIGURED, DMA_AND_PCAP_DONE, DMA_DONE, AXI_ERROR = 1 << 2, 1 << 12, 1 << 13, 1 << 22
QSPI_LEFT = 0x8403_FDFE
"""Content of QSPI_CONFIG that a boot ROM may leave: manual mode, deselected, slave, divided by 256,
other clock mode."""
QSPI_LINEAR = 0x8008_00C1
"""Bits of QSPI_CONFIG that linear reading needs: flash interface, HOLD driven high, 32-bit words,
master (UG585, qspi.Config_reg)."""
QSPI_NEVER = 0x0401_C506
"""Bits of QSPI_CONFIG that must be 0 for linear reading: byte order, start, manual modes,
deselected, reference clock, phase, polarity."""
QSPI_REFERENCE_MHZ = 200
QSPI_MOST_MHZ = 40
"""Largest clock of the flash in MHz. With a faster clock the data come too late, so that the flash
interface needs the loop-back of MIO 8."""


def addresses() -> dict[str, int]:
    """Return the addresses that zynq/registers.h defines, by name."""
    text = (FIRMWARE / "zynq" / "registers.h").read_text("utf-8")
    bases = dict(re.findall(r"#define (\w+_BASE) (0x[0-9A-F]+)U\n", text))
    found = {name: int(value, 16) for name, value in bases.items()}
    for name, value in re.findall(r"#define (\w+) (0x[0-9A-F]{8})U\n", text):
        found[name] = int(value, 16)
    for name, base, offset in re.findall(r"#define (\w+) \((\w+_BASE) \+ (0x\w+)U\)", text):
        found[name] = int(bases[base], 16) + int(offset, 16)
    return found


AT = addresses()


def bitstream(length: int = 300_000, seed: int = 1) -> bytes:
    """Return padding, the synchronisation word in the port's byte order, and a body."""
    head = b"\xff" * 48 + struct.pack("<I", SYNC_WORD)
    word = struct.pack("<I", 0x9E37_79B9 * seed & 0xFFFF_FFFF)
    body = word * ((length - len(head)) // 4)
    return head + body


def image(body: bytes, **other: int) -> bytes:
    """Return header and bitstream in the form in which the image builder writes them."""
    fields = {"magic": 0x53425441, "version": 1, "length": len(body), "crc": zlib.crc32(body)}
    fields |= other
    return struct.pack("<16I", *fields.values(), *[0] * 12) + body


class ZynqModel:
    """A model of the registers. ``stuck`` names what fails: init_high, init_low, clear, dma,
    dma_error, done or queue."""

    def __init__(self, flash: bytes = b"", boot_mode: int = 1, stuck: str = "") -> None:
        self.flash = flash
        self.stuck = stuck
        self.now_us = 0
        self.unlocked: set[str] = set()
        self.words: dict[int, int] = {AT["SLCR_BOOT_MODE"]: boot_mode}
        self.words[AT["DEVC_CTRL"]] = 0x0C00_6000
        self.words[AT["DEVC_MCTRL"]] = 0x3080_0100 | LOOPBACK
        self.words[AT["SLCR_LVL_SHFTR_EN"]] = 0
        self.words[AT["QSPI_CONFIG"]] = QSPI_LEFT
        self.words[AT["QSPI_LPBK_DLY_ADJ"]] = 0x20
        self.words[AT["SLCR_FPGA_RST_CTRL"]] = 0xF
        self.interrupt_status = 0
        self.init = False
        self.received = b""
        self.pieces: list[int] = []
        self.finished_us: int | None = None
        # Microseconds from the end of the DMA until the port has read all words.
        self.port_us = 1000
        self.port_done_us: int | None = None
        # Microseconds from the end of a transfer until the transfer leaves the queue.
        self.queue_us = 40
        self.queue_empty_us = 0
        self.temperature_code: int | None = 0x977
        self.answers: deque[int] = deque()
        self.previous = 0
        self.log: list[str] = []
        ffi, _ = firmware()
        self._calls = (
            ffi.callback("register_access_read", self.read),
            ffi.callback("register_access_write", self.write),
            ffi.callback("register_access_microseconds", lambda _: self.now_us & 0xFFFF_FFFF),
        )
        self.access = ffi.new("struct register_access *", list(self._calls))

    def value(self, name: str) -> int:
        return self.words.get(AT[name], 0)

    def read(self, _: Any, address: int) -> int:
        self.now_us += READ_US
        if address >= FLASH:
            return self.flash_word(address)
        assert not 0x4000_0000 <= address < 0xC000_0000, "an access that never ends"
        if address == AT["DEVC_INT_STS"]:
            self.finish_transfer()
            return self.interrupt_status
        if address == AT["DEVC_STATUS"]:
            queue = QUEUE_EMPTY if self.now_us >= self.queue_empty_us else 0
            queue = QUEUE_FULL if self.stuck == "queue" else queue
            return queue | (INIT if self.init else 0)
        if address == AT["XADC_MSTS"]:
            return 0 if self.answers else 0x100
        if address == AT["XADC_RDFIFO"]:
            return self.answers.popleft()
        return self.words.get(address, 0)

    def flash_word(self, address: int) -> int:
        assert self.words[AT["QSPI_LQSPI_CFG"]] >> 31, "linear mode is off"
        assert self.words[AT["QSPI_EN"]] == 1, "the controller is off"
        config = self.words[AT["QSPI_CONFIG"]]
        assert config & QSPI_LINEAR == QSPI_LINEAR
        assert not config & QSPI_NEVER
        assert QSPI_REFERENCE_MHZ / (2 << (config >> 3 & 7)) <= QSPI_MOST_MHZ
        assert not self.value("QSPI_LPBK_DLY_ADJ") & 0x20, "the loop-back is for faster clocks"
        place = address - FLASH - IMAGE_OFFSET
        word = self.flash[place : place + 4].ljust(4, b"\xff")
        return int.from_bytes(word, "little")

    def write(self, _: Any, address: int, word: int) -> None:
        (name,) = [n for n, a in AT.items() if a == address and not n.endswith("_BASE")][:1]
        self.log.append(name)
        if name in UNLOCK_KEYS:
            assert word == UNLOCK_KEYS[name]
            self.unlocked.add(name)
        elif name.startswith("SLCR"):
            assert "SLCR_UNLOCK" in self.unlocked
        elif name.startswith("DEVC"):
            assert "DEVC_UNLOCK" in self.unlocked
        if name == "DEVC_INT_STS":
            self.interrupt_status &= ~word
        elif name == "XADC_CMDFIFO":
            self.command(word)
        else:
            self.words[address] = word
        if name == "DEVC_CTRL":
            self.program(word)
        elif name == "DEVC_DMA_DST_LEN":
            self.start_transfer()

    def program(self, control: int) -> None:
        if control & PROG_B:
            self.init = self.stuck != ("clear" if self.received is None else "init_high")
        else:
            assert self.value("SLCR_LVL_SHFTR_EN") == 0xA, "only processor to fabric"
            self.interrupt_status &= ~CONFIGURED
            self.init = self.stuck == "init_low"
            self.received = None  # type: ignore[assignment]

    def start_transfer(self) -> None:
        assert not self.value("DEVC_MCTRL") & LOOPBACK
        assert self.now_us >= self.queue_empty_us, "a transfer starts before the last one has ended"
        assert self.value("DEVC_DMA_DST_ADDR") == 0xFFFF_FFFF
        source = self.value("DEVC_DMA_SRC_ADDR")
        assert source & 0x3F in (0, 1), "the address is a multiple of 64, plus 1 for the last piece"
        length = 4 * self.value("DEVC_DMA_SRC_LEN")
        start = (source & ~1) - FLASH - IMAGE_OFFSET
        self.received = (self.received or b"") + self.flash[start : start + length]
        self.pieces.append(length)
        # The flash is slow and delivers 5 MB/s.
        self.finished_us = self.now_us + length // 5
        self.last = bool(source & 1)

    def finish_transfer(self) -> None:
        self.finish_port()
        if self.finished_us is None or self.now_us < self.finished_us or self.stuck == "dma":
            return
        self.finished_us = None
        if self.stuck == "dma_error":
            self.interrupt_status |= AXI_ERROR
            return
        self.interrupt_status |= DMA_DONE
        self.queue_empty_us = self.now_us + self.queue_us
        if self.last:
            self.port_done_us = self.now_us + self.port_us

    def finish_port(self) -> None:
        if self.port_done_us is None or self.now_us < self.port_done_us:
            return
        self.port_done_us = None
        self.interrupt_status |= DMA_AND_PCAP_DONE
        if struct.pack("<I", SYNC_WORD) in self.received and self.stuck != "done":
            self.interrupt_status |= CONFIGURED

    def command(self, word: int) -> None:
        assert self.value("XADC_CFG") >> 31, "the port is off"
        if self.temperature_code is None:
            return
        reads = word >> 26 & 0xF == 1 and word >> 16 & 0x3FF == 0
        self.answers.append(self.previous)
        self.previous = self.temperature_code << 4 if reads else 0
