"""Defines the AXI4-Lite master of the test benches, and the register map that uses it."""

from __future__ import annotations

import itertools
import random
from collections.abc import Iterator, Sequence
from typing import Any

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles
from cocotbext.axi import AxiLiteBus, AxiLiteMaster, AxiResp

from arctrue.gateware.register_access import RegisterMap

MASTER_DRIVES = (
    "awvalid",
    "awaddr",
    "wvalid",
    "wdata",
    "wstrb",
    "bready",
    "arvalid",
    "araddr",
    "rready",
)


class BusError(Exception):
    """Raised if the bus's answer is not OKAY, by the functions that do not return this answer."""


def stalls(generator: random.Random, share: float) -> Iterator[bool]:
    """Yield True (pause) in a ``share`` of the clocks, in bursts of random length, without end."""
    while True:
        pause = generator.random() < share
        yield from itertools.repeat(pause, generator.randint(1, 6))


class Bus:
    """Reads and writes words over AXI4-Lite with one master."""

    def __init__(self, master: Any) -> None:
        self.master = master

    def stall(self, generator: random.Random, share: float) -> None:
        """Make the master pause at random on all five channels."""
        write, read = self.master.write_if, self.master.read_if
        for channel in (
            write.aw_channel,
            write.w_channel,
            write.b_channel,
            read.ar_channel,
            read.r_channel,
        ):
            channel.set_pause_generator(stalls(generator, share))

    async def read(self, address: int) -> tuple[AxiResp, int]:
        """Read a word; return the answer of the bus and the word."""
        answer = await self.master.read(address, 4)
        return answer.resp, int.from_bytes(answer.data, "little")

    async def write(self, address: int, word: int, strobes: int = 0b1111) -> AxiResp:
        """Write a word; return the answer of the bus. The ones in ``strobes`` must be adjacent."""
        lanes = [byte for byte in range(4) if strobes >> byte & 1]
        assert lanes == list(range(lanes[0], lanes[-1] + 1)), "one run of bytes only"
        data = word.to_bytes(4, "little")[lanes[0] : lanes[-1] + 1]
        return (await self.master.write(address + lanes[0], data)).resp

    async def read_words(self, address: int, count: int) -> list[int]:
        """Return ``count`` words, read back to back; raise BusError if an answer is not OKAY."""
        answer = await self.master.read(address, 4 * count)
        if answer.resp != AxiResp.OKAY:
            raise BusError(f"read of {count} words at 0x{address:05X}: {answer.resp!r}")
        return [
            int.from_bytes(answer.data[place : place + 4], "little")
            for place in range(0, 4 * count, 4)
        ]

    async def write_words(self, address: int, words: Sequence[int]) -> None:
        """Write words in order, back to back; raise BusError if an answer is not OKAY."""
        answer = await self.master.write(
            address, b"".join(word.to_bytes(4, "little") for word in words)
        )
        if answer.resp != AxiResp.OKAY:
            raise BusError(f"write of {len(words)} words at 0x{address:05X}: {answer.resp!r}")

    def registers(self) -> RegisterMap:
        """Return a register map that accesses registers by name over this bus."""
        return RegisterMap(self.read_words, self.write_words)


async def start(dut: Any, *, period_ns: int = 10, reset_clocks: int = 8) -> Bus:
    """Start the clock, reset ``dut`` and return the bus on its ports ``s_axil_*``.

    Before the master is made, the reset is high and the master's signals are zero, because the
    master must not read undefined levels ('U').
    """
    for name in MASTER_DRIVES:
        getattr(dut, f"s_axil_{name}").value = 0
    dut.reset.value = 1
    cocotb.start_soon(Clock(dut.clock, period_ns, unit="ns", impl="gpi").start())
    await ClockCycles(dut.clock, reset_clocks)
    bus = AxiLiteBus.from_prefix(dut, "s_axil")
    master = AxiLiteMaster(bus, dut.clock, dut.reset)
    for interface in (master.write_if, master.read_if):
        interface.log.setLevel("WARNING")  # logging an access takes longer than the access
    dut.reset.value = 0
    await ClockCycles(dut.clock, 2)
    return Bus(master)
