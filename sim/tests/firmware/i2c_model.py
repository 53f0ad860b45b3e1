"""Models the Zynq's I2C controller and two thermometers on its bus.

The models are written from UG585 (chapter 20 and its register tables) and the data sheets of
ADT7420 and TMP117, not from the C code: only register addresses come from its header
zynq/registers.h.
"""

from __future__ import annotations

import math
from collections import deque
from typing import Any, Protocol

from sim.tests.firmware.library import firmware
from sim.tests.firmware.zynq_model import AT

DONE, NO_ACKNOWLEDGE = 1, 4
RECEIVED = 1 << 5
SCL, SDA = 1, 2
"""Bits of the general-purpose pins that the fabric connects to the bus (EMIO)."""
GPIO_OUT, GPIO_IN, GPIO_DIRECTION, GPIO_ENABLE = 0xE000_A048, 0xE000_A068, 0xE000_A284, 0xE000_A288
"""Addresses of bank 2: DATA_2, DATA_2_RO, DIRM_2, OEN_2 (UG585, appendix B.19)."""
I2C_RESET, I2C0_RESET = 0xF800_0224, 1
READ, MASTER, SEVEN_BITS, ACKNOWLEDGE, CLEAR_QUEUE = 1, 2, 4, 8, 64
QUEUE = 16


class Device(Protocol):
    """A device on the I2C bus; a write contains a register pointer and the data for that
    register."""

    def write(self, data: bytes) -> bool:
        """Take written data; return False if the device does not acknowledge."""

    def read(self, number: int) -> bytes: ...


class Adt7420:
    """A thermometer with one-byte registers; two of them hold the temperature, in 13 or 16 bits."""

    def __init__(self, celsius: float = 25.0) -> None:
        self.celsius = celsius
        self.power_on()

    def power_on(self) -> None:
        self.pointer = 0
        self.registers = {0x03: 0x00, 0x0B: 0xCB}

    def write(self, data: bytes) -> bool:
        self.pointer = data[0]
        for place, byte in enumerate(data[1:]):
            self.registers[self.pointer + place] = byte
        return True

    def read(self, number: int) -> bytes:
        steps = round(self.celsius * 128)
        if not self.registers[0x03] & 0x80:
            # 13 bits are in steps of 1/16 K; the three lower bits are flags.
            steps = round(self.celsius * 16) << 3 | 0b101
        temperature = (steps & 0xFFFF).to_bytes(2, "big")
        found = {0x00: temperature[0], 0x01: temperature[1], **self.registers}
        return bytes(found.get(self.pointer + place, 0) for place in range(number))


class Tmp117:
    """A thermometer with two-byte registers; before its first conversion it shows -256 °C."""

    def __init__(self, celsius: float | None = 25.0) -> None:
        self.celsius = celsius
        self.pointer = 0

    def write(self, data: bytes) -> bool:
        self.pointer = data[0]
        return True

    def read(self, number: int) -> bytes:
        steps = -32768 if self.celsius is None else round(self.celsius * 128)
        words = {0x00: steps & 0xFFFF, 0x0F: 0x1117}
        return words.get(self.pointer, 0).to_bytes(2, "big").ljust(number, b"\0")[:number]


class I2cModel:
    """The I2C controller; with ``stuck`` a transfer never ends.

    A device that was cut off within a byte holds SDA low for the number of clocks that ``hold_sda``
    sets, and then waits for a STOP. A transfer that begins before the STOP hangs the controller
    until its reset.
    """

    def __init__(self, **devices: Device) -> None:
        """Connect devices, each with the address in its keyword: ``at_48=...``."""
        self.devices = {int(name.removeprefix("at_"), 16): item for name, item in devices.items()}
        self.stuck = False
        self.now_us = 0
        self.bits_held = 0
        self.amid_a_byte = False
        self.hung = False
        self.fastest_us = math.inf
        self.log: list[tuple[int, int]] = []
        self._wires = SCL | SDA
        self._changed_us = -1000
        self.queue: deque[int] = deque()
        self.words: dict[int, int] = {}
        self.happened = 0x3FF
        self.transfers = 0
        ffi, _ = firmware()
        self._calls = (
            ffi.callback("register_access_read", self.read),
            ffi.callback("register_access_write", self.write),
            ffi.callback("register_access_microseconds", self.microseconds),
        )
        self.access = ffi.new("struct register_access *", list(self._calls))

    def hold_sda(self, clocks: int) -> None:
        self.bits_held = clocks
        self.amid_a_byte = True

    def wires(self) -> int:
        """Return SCL and SDA: low if the pins or the device pull them, otherwise high."""
        driven = self.words.get(GPIO_DIRECTION, 0) & self.words.get(GPIO_ENABLE, 0)
        assert not driven & self.words.get(GPIO_OUT, 0), "no wire is ever driven high"
        return (SCL | SDA) & ~driven & ~(SDA if self.bits_held else 0)

    def follow_wires(self) -> None:
        before, now = self._wires, self.wires()
        if before == now:
            return
        if (before ^ now) & SCL:
            self.fastest_us = min(self.fastest_us, self.now_us - self._changed_us)
            self._changed_us = self.now_us
        self._wires = now
        if now & SCL and not before & SCL and self.bits_held:
            self.bits_held -= 1
            self._wires = self.wires()
        elif before & now & SCL and now & SDA:
            # This is a STOP: SDA rises while SCL is high.
            self.amid_a_byte = False

    def reset(self) -> None:
        self.hung = False
        self.queue.clear()
        self.happened = 0
        for name in ("I2C_CONTROL", "I2C_TIME_OUT"):
            self.words.pop(AT[name], None)

    def microseconds(self, _: Any) -> int:
        self.now_us += 1
        return self.now_us & 0xFFFF_FFFF

    def read(self, _: Any, address: int) -> int:
        self.now_us += 1
        if address == GPIO_IN:
            return self.wires()
        if address == AT["I2C_HAPPENED"]:
            return self.happened
        if address == AT["I2C_STATUS"]:
            return RECEIVED if self.queue else 0
        if address == AT["I2C_DATA"]:
            return self.queue.popleft()
        return self.words.get(address, 0)

    def write(self, _: Any, address: int, word: int) -> None:
        self.log.append((address, word))
        if address == AT["I2C_HAPPENED"]:
            self.happened &= ~word
        elif address == AT["I2C_DATA"]:
            assert len(self.queue) < QUEUE
            self.queue.append(word)
        elif address == AT["I2C_ADDRESS"]:
            self.transfer(word)
        elif address == I2C_RESET and word & I2C0_RESET:
            self.reset()
        else:
            if address == AT["I2C_CONTROL"] and word & CLEAR_QUEUE:
                self.queue.clear()
                word &= ~CLEAR_QUEUE
            self.words[address] = word
            self.follow_wires()

    def transfer(self, address: int) -> None:
        control = self.words[AT["I2C_CONTROL"]]
        assert control & (MASTER | SEVEN_BITS | ACKNOWLEDGE) == MASTER | SEVEN_BITS | ACKNOWLEDGE
        assert self.happened & (DONE | NO_ACKNOWLEDGE) == 0, (
            "the events of the last transfer were not cleared"
        )
        assert self.words[AT["I2C_TIME_OUT"]] == 0xFF
        assert not self.words.get(GPIO_DIRECTION, 0), "the pins still drive the wires"
        self.transfers += 1
        self.hung = self.hung or self.amid_a_byte
        if self.stuck or self.hung:
            return
        device = self.devices.get(address)
        if device is None:
            self.happened |= NO_ACKNOWLEDGE
        elif control & READ:
            assert not self.queue
            self.queue.extend(device.read(self.words[AT["I2C_SIZE"]]))
            self.happened |= DONE
        else:
            taken = device.write(bytes(self.queue))
            self.queue.clear()
            self.happened |= DONE if taken else NO_ACKNOWLEDGE

    def scl_hz(self, bus_hz: int) -> float:
        """Return the frequency of SCL by UG585: FSCL = bus / (22 (A + 1) (B + 1))."""
        control = self.words[AT["I2C_CONTROL"]]
        return bus_hz / (22 * ((control >> 14 & 3) + 1) * ((control >> 8 & 63) + 1))
