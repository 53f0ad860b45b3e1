"""Tests of the UART's C code with a model of the registers, because QEMU does not imitate their
timing.

The model is written from UG585, chapter 19 and appendix B.33: FIFOs, a transmitter that still
shifts when its FIFO is empty, resets that end by themselves, and a receiver trigger that is set
when its level is reached and stays set until it is cleared.
"""

from __future__ import annotations

import shutil
import subprocess
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from cffi import FFI
from sim.tests.firmware.library import FIRMWARE, GENERATED
from sim.tests.firmware.zynq_model import AT

BOARD = FIRMWARE / "board"
REGISTERS = {AT[name]: name for name in AT if name.startswith("UART_") and name != "UART_BASE"}
RX_RESET, TX_RESET, RX_ON, RX_OFF, TX_ON, TX_OFF = (1 << bit for bit in range(6))
RX_EMPTY, TX_EMPTY, TX_FULL, TX_ACTIVE = 1 << 1, 1 << 3, 1 << 4, 1 << 11
RX_TRIGGER = 1
RX_OVERFLOW = 1 << 5
FIFO = 64
RESET_READS = 3
CHARACTER_READS = 20
"""Number of register reads per character. The model advances its time with each read; at 115,200
baud a real character takes hundreds of reads."""

SEAM = """
#include <stdint.h>
extern uint32_t (*model_read)(uint32_t);
extern void (*model_write)(uint32_t, uint32_t);
static inline uint32_t register_read(uint32_t address) { return model_read(address); }
static inline void register_write(uint32_t address, uint32_t word) { model_write(address, word); }
"""
DECLARATIONS = """
extern uint32_t (*model_read)(uint32_t);
extern void (*model_write)(uint32_t, uint32_t);
struct uart { uint32_t written; uint32_t taken; uint32_t overruns; bool lost; uint8_t ring[4096]; };
void uart_set_up(struct uart *uart);
void uart_interrupt(struct uart *uart);
struct uart_output { uint32_t written; uint32_t sent; bool filling; uint8_t ring[4096]; };
size_t uart_room(const struct uart_output *output);
void uart_send(struct uart_output *output, const char *characters, size_t number);
void uart_go_on(struct uart_output *output);
bool uart_take(struct uart *uart, uint8_t *character);
void uart_put(char character);
void uart_drain(void);
"""


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> tuple[FFI, Any]:
    return compiled_for(tmp_path_factory.mktemp("uart"))


def compiled_for(folder: Path, *options: str) -> tuple[FFI, Any]:
    """Compile board/uart.c with the model instead of the bus."""
    seam, made = folder / "seam.h", folder / "uart.so"
    seam.write_text(SEAM, encoding="ascii")
    places = folder / "places.c"
    places.write_text("uint32_t (*model_read)(uint32_t); void (*model_write)(uint32_t, uint32_t);")
    shutil.copy(BOARD / "processor_side.h", folder / "board_settings.h")
    includes = [f"-I{path}" for path in (folder, BOARD, FIRMWARE / "zynq", GENERATED)]
    command = ["gcc", "-std=c11", "-shared", "-fPIC", "-O1", "-Wall", "-Wextra", "-Werror"]
    command += ["-DARCTRUE_MEMORY_MAPPED_H", "-include", str(seam), *includes, *options]
    subprocess.run([*command, BOARD / "uart.c", places, "-o", made], check=True)
    ffi = FFI()
    ffi.cdef(DECLARATIONS)
    return ffi, ffi.dlopen(str(made))


class Uart:
    """The controller; ``arrivals`` maps the number of a register read to the character that arrives
    before it."""

    def __init__(self, compiled: tuple[FFI, Any]) -> None:
        self.ffi, self.library = compiled
        self.words = dict.fromkeys(REGISTERS.values(), 0)
        self.words["UART_CR"] = RX_OFF | TX_OFF
        self.words["UART_RXWM"] = FIFO // 2
        self.status = 0
        self.reads = 0
        self.resetting = 0
        self.received: deque[int] = deque()
        self.waiting: deque[int] = deque()
        self.shifting: int | None = None
        self.shifted_at = 0
        self.sent = bytearray()
        self.arrivals: dict[int, int] = {}
        self.ticks_every = 0
        self._calls = (
            self.ffi.callback("uint32_t(uint32_t)", self.read),
            self.ffi.callback("void(uint32_t, uint32_t)", self.write),
        )
        self.library.model_read, self.library.model_write = self._calls
        self.ring = self.ffi.new("struct uart *")
        self.output = self.ffi.new("struct uart_output *")

    def arrive(self, character: int) -> None:
        if len(self.received) >= FIFO:
            self.status |= RX_OVERFLOW
        elif self.words["UART_CR"] & RX_ON:
            self.received.append(character)
            if len(self.received) == self.words["UART_RXWM"]:
                self.status |= RX_TRIGGER

    def time_goes_on(self) -> None:
        self.reads += 1
        if self.reads in self.arrivals:
            self.arrive(self.arrivals.pop(self.reads))
        if self.resetting:
            self.resetting -= 1
            if not self.resetting:
                self.words["UART_CR"] &= ~(RX_RESET | TX_RESET)
        if self.shifting is not None and self.reads >= self.shifted_at:
            self.sent.append(self.shifting)
            self.shifting = None
        if self.shifting is None and self.waiting:
            self.shifting = self.waiting.popleft()
            self.shifted_at = self.reads + CHARACTER_READS
        if self.ticks_every and self.reads % self.ticks_every == 0:
            # The timer's interrupt comes at any time, but not while its handler runs.
            every, self.ticks_every = self.ticks_every, 0
            self.library.uart_go_on(self.output)
            self.ticks_every = every

    def read(self, address: int) -> int:
        self.time_goes_on()
        name = REGISTERS[address]
        if name == "UART_SR":
            return (
                (0 if self.received else RX_EMPTY)
                | (0 if self.waiting else TX_EMPTY)
                | (TX_FULL if len(self.waiting) >= FIFO else 0)
                | (0 if self.shifting is None else TX_ACTIVE)
            )
        if name == "UART_FIFO":
            return self.received.popleft()
        return self.status if name == "UART_ISR" else self.words[name]

    def write(self, address: int, word: int) -> None:
        name = REGISTERS[address]
        if name == "UART_FIFO":
            assert self.words["UART_CR"] & TX_ON
            assert len(self.waiting) < FIFO
            self.waiting.append(word)
            return
        if name == "UART_ISR":
            self.status &= ~word
            return
        if name in ("UART_BAUDGEN", "UART_BAUDDIV", "UART_MR"):
            assert not self.words["UART_CR"] & (RX_ON | TX_ON), (
                "the set-up changes while the UART is on"
            )
        if name == "UART_CR":
            assert not self.resetting, "a reset is interrupted"
            if word & (RX_RESET | TX_RESET):
                self.resetting = RESET_READS
                self.received.clear()
                self.waiting.clear()
                self.shifting = None
        self.words[name] = word

    def set_up(self) -> None:
        self.library.uart_set_up(self.ring)

    def say(self, text: bytes) -> None:
        for character in text:
            self.library.uart_put(bytes([character]))

    def interrupts(self) -> None:
        """Call the interrupt handler as long as the interrupt line is high."""
        for _ in range(10):
            if not self.status & self.words["UART_IER"]:
                return
            self.library.uart_interrupt(self.ring)
        raise AssertionError("the line stays high")

    def heard(self) -> bytes:
        character = self.ffi.new("uint8_t *")
        said = bytearray()
        while self.library.uart_take(self.ring, character):
            said.append(character[0])
        return bytes(said)


@pytest.fixture
def uart(compiled: tuple[FFI, Any]) -> Uart:
    made = Uart(compiled)
    made.set_up()
    return made


def test_the_rate_and_the_paths(uart: Uart) -> None:
    assert uart.words["UART_CR"] & 0x3F == RX_ON | TX_ON
    clocks = uart.words["UART_BAUDGEN"] * (uart.words["UART_BAUDDIV"] + 1)
    assert 100e6 / clocks == pytest.approx(115_200, rel=1e-3)
    assert 4 <= uart.words["UART_BAUDDIV"] <= 255, "UG585: from 4 on"


@pytest.mark.parametrize("baud", [9600, 57_600, 115_200, 230_400, 921_600, 2_000_000, 3_000_000])
def test_another_rate_of_the_build(tmp_path: Path, baud: int) -> None:
    """Each rate that the build offers is met within 1.02 %, the error due to rounded divisors. At 3
    Mbaud a bit has 33⅓ clocks, which rounding changes by 1.01 %; sender and receiver together may
    deviate by 5 %."""
    uart = Uart(compiled_for(tmp_path, f"-DBOARD_BAUD={baud}U"))
    uart.set_up()
    divisor, samples = uart.words["UART_BAUDGEN"], uart.words["UART_BAUDDIV"] + 1
    assert 100e6 / (divisor * samples) == pytest.approx(baud, rel=0.0102)
    assert 1 <= divisor <= 65_535
    assert 5 <= samples <= 256
    uart.say(b"ok")
    uart.library.uart_drain()
    assert uart.sent == b"ok"


@pytest.mark.parametrize("length", [1, 70, 300])
def test_all_is_sent_before_the_next_set_up(uart: Uart, length: int) -> None:
    """All characters of a message are sent before the firmware restarts, which resets both paths of
    the UART."""
    text = bytes(32 + place % 90 for place in range(length))
    uart.say(text)
    uart.library.uart_drain()
    uart.set_up()
    assert uart.sent == text


@pytest.mark.parametrize("first", range(1, 12))
@pytest.mark.parametrize("apart", [1, 2, 3])
def test_a_character_that_comes_at_any_moment_is_heard(uart: Uart, first: int, apart: int) -> None:
    """The firmware receives a character even if it arrives between the handler's last read and the
    handler's end."""
    uart.arrive(ord("a"))
    uart.arrivals = {uart.reads + first: ord("b"), uart.reads + first + apart: ord("c")}
    for _ in range(30):
        uart.interrupts()
        uart.time_goes_on()
    assert uart.heard() == b"abc"


def test_more_than_the_ring_holds_is_lost_and_no_more(uart: Uart) -> None:
    for character in range(5000):
        uart.arrive(character % 251)
        uart.interrupts()
    assert uart.heard() == bytes(place % 251 for place in range(4096))
    uart.arrive(7)
    uart.interrupts()
    assert uart.heard() == b"\x00\x07", "a character 0 marks the loss"
    assert uart.ring.overruns == 1


@pytest.mark.parametrize("more", [1, 30])
def test_a_fifo_that_overflows_is_reported_where_it_did(uart: Uart, more: int) -> None:
    """The ring marks the place where the FIFO overflowed: interrupts were off while more than 64
    characters arrived."""
    for place in range(FIFO + more):
        uart.arrive(32 + place)
    uart.arrivals = {uart.reads + 9: ord("x")}
    uart.interrupts()
    uart.arrive(ord("y"))
    uart.interrupts()
    kept = bytes(32 + place for place in range(FIFO))
    assert uart.heard() == kept + b"\x00xy"
    assert uart.ring.overruns == 1
    uart.set_up()
    assert uart.ring.overruns == 0


CHARACTER_US = 10 / 115_200 * 1e6
LINE = 2128
"""Number of characters of a telemetry line with 40 orders."""


def stall_us(uart: Uart, say: Callable[[], None]) -> float:
    """Return the number of microseconds by which this output delays the main program."""
    before = uart.reads
    say()
    return (uart.reads - before) / CHARACTER_READS * CHARACTER_US


def test_a_line_of_telemetry_holds_nothing_up(uart: Uart) -> None:
    """With the output ring, a line of telemetry delays the program only by the register accesses
    that fill the FIFO. Without the ring, the line delays the program by the time of all characters
    that the FIFO cannot hold."""
    text = bytes(32 + place % 90 for place in range(LINE))
    waited = stall_us(uart, lambda: uart.say(text))
    assert waited == pytest.approx((LINE - FIFO) * CHARACTER_US, rel=0.02)
    uart.library.uart_drain()
    uart.sent.clear()
    # A register read takes 4 us in the model; on the chip it takes 0.1 us.
    at_once = stall_us(uart, lambda: uart.library.uart_send(uart.output, text, LINE))
    assert at_once < 1.2 * FIFO / CHARACTER_READS * CHARACTER_US
    assert uart.library.uart_room(uart.output) == 4096 - LINE + uart.output.sent
    while uart.library.uart_room(uart.output) < 4096:
        # The interrupt of the timer comes every 5 ms.
        for _ in range(int(5000 / CHARACTER_US * CHARACTER_READS)):
            uart.time_goes_on()
        assert uart.waiting, "the FIFO never runs empty, so the transmitter never pauses"
        uart.library.uart_go_on(uart.output)
    uart.library.uart_drain()
    assert uart.sent == text


@pytest.mark.parametrize("every", [1, 2, 3, 7, 50])
def test_the_order_is_kept_whenever_the_interrupt_comes(uart: Uart, every: int) -> None:
    """The order of the characters is kept: the text is longer than the ring, the sender waits for
    room, and no character is lost or sent twice."""
    text = bytes(32 + place * 7 % 90 for place in range(3 * 4096))
    uart.ticks_every = every
    for first in range(0, len(text), 37):
        part = text[first : first + 37]
        uart.library.uart_send(uart.output, part, len(part))
    while uart.library.uart_room(uart.output) < 4096:
        uart.time_goes_on()
        uart.library.uart_go_on(uart.output)
    uart.ticks_every = 0
    uart.library.uart_drain()
    assert uart.sent == text
