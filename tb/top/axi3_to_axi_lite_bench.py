"""Tests that the bridge makes, for AXI3 bursts, AXI4-Lite accesses to the addresses that the AXI
specification states (A3.4.1)."""

from __future__ import annotations

import random
from collections import deque
from dataclasses import dataclass, field
from typing import Any

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

from arctrue.generated.registers import MAP_BYTES

BASE = 0x4000_0000
FIXED, INCR, WRAP = 0, 1, 2
OKAY, SLVERR, DECERR = 0, 2, 3
BAD_WORDS = {0x0A4: SLVERR, 0x1A8: DECERR}  # words that the model slave refuses in every KiB
LONGEST_WAIT = 4000  # in clocks; 16 beats take about 1000 if nine of ten clocks are stalls


@dataclass(frozen=True)
class Burst:
    write: bool
    identity: int
    address: int
    beats: int
    size: int
    kind: int
    data: tuple[int, ...] = ()
    strobes: tuple[int, ...] = ()
    last_at: int = -1  # beat with WLAST, if it is not the last one

    def refused(self) -> int:
        """Return the answer with which the bridge refuses the burst without an access; OKAY if it
        does not refuse the burst."""
        if self.kind > WRAP or self.size > 2:
            return SLVERR
        if self.kind == WRAP and (self.beats not in (2, 4, 8, 16) or self.address % 2**self.size):
            return SLVERR
        return OKAY if BASE <= self.address < BASE + MAP_BYTES else DECERR

    def addresses(self) -> list[int]:
        """Return the address of each beat, Address_N in the equations of the specification."""
        number_bytes = 2**self.size
        aligned = self.address // number_bytes * number_bytes
        found = [self.address]
        boundary = self.address // (number_bytes * self.beats) * (number_bytes * self.beats)
        for n in range(1, self.beats):
            address = self.address if self.kind == FIXED else aligned + n * number_bytes
            if self.kind == WRAP and address >= boundary + number_bytes * self.beats:
                address -= number_bytes * self.beats
            found.append(address)
        return found


def words_of(burst: Burst) -> list[int]:
    return [(address - BASE) // 4 * 4 for address in burst.addresses()]


def answer_of(word: int) -> int:
    return BAD_WORDS.get(word % 0x400, OKAY)


def content(word: int) -> int:
    return word * 0x9E3779B1 + 0x1234567 & 0xFFFF_FFFF


def expected_writes(burst: Burst) -> list[tuple[int, int, int]]:
    if burst.refused() != OKAY:
        return []
    beats = zip(words_of(burst), burst.data, burst.strobes, strict=True)
    return [beat for beat in beats if beat[2]]


def expected_write_answer(burst: Burst) -> int:
    answers = []
    for n, word in enumerate(words_of(burst)):
        refused = burst.refused()
        if burst.last_at >= 0 and (n == burst.last_at) != (n == burst.beats - 1):
            refused = SLVERR
        answers.append(refused)
        if burst.refused() == OKAY and burst.strobes[n]:
            answers.append(answer_of(word))
    return next((answer for answer in answers if answer != OKAY), OKAY)


def expected_reads(burst: Burst) -> list[tuple[int, int, int, int]]:
    beats = []
    for n, word in enumerate(words_of(burst)):
        answer = burst.refused() or answer_of(word)
        data = 0 if burst.refused() else content(word)
        beats.append((burst.identity, answer, data, int(n == burst.beats - 1)))
    return beats


def random_burst(chance: random.Random) -> Burst:
    kind = chance.choice((FIXED, INCR, INCR, WRAP, WRAP))
    size = chance.choice((0, 1, 2, 2))
    beats = chance.choice((2, 4, 8, 16)) if kind == WRAP else chance.randint(1, 16)
    last = 0x1000 - 2**size * beats if kind == INCR else 0xFFC
    # Addresses lie near one of the two ends of the window.
    address = BASE + chance.choice((0, MAP_BYTES - 0x4000))
    address += chance.randrange(4) * 0x1000 + chance.randint(0, last)
    if kind == WRAP:
        address -= address % 2**size
    broken = chance.random()
    if broken < 0.04:
        kind = 3
    elif broken < 0.08:
        size = chance.randint(3, 7)
    elif broken < 0.12:
        address += MAP_BYTES
    elif broken < 0.16 and kind == WRAP:
        beats = chance.choice((1, 3, 5, 6, 7, 9, 15))
    elif broken < 0.20 and kind == WRAP:
        size, address = 2, address | 1
    write = chance.random() < 0.5
    strobes = tuple(chance.choice((15, 15, 1, 2, 4, 8, 3, 12, 0)) for _ in range(beats))
    return Burst(
        write,
        chance.randrange(4096),
        address,
        beats,
        size,
        kind,
        tuple(chance.getrandbits(32) for _ in range(beats)) if write else (),
        strobes if write else (),
        chance.randrange(beats) if write and chance.random() < 0.05 else -1,
    )


@dataclass
class Channel:
    """Sender of one channel; ``waiting`` holds its payloads, ``valid`` is the level of its valid
    signal."""

    port: str
    stall: float
    waiting: deque[dict[str, int]] = field(default_factory=deque)
    valid: bool = False


class Machine:
    """Simulates the master and the slave of the bridge; ``clock`` runs all channels for one clock.

    The bridge changes its outputs only at a rising edge. Inputs are set at the falling edge; the
    next rising edge samples the levels that all ports then have.
    """

    def __init__(self, dut: Any, chance: random.Random, stall: float) -> None:
        self.dut = dut
        self.chance = chance
        self.stall = stall
        self.accesses: list[tuple[int, int, int]] = []
        self.write_answers: list[tuple[int, int]] = []
        self.read_beats: list[tuple[int, int, int, int]] = []
        self.held: dict[str, tuple[int, ...]] = {}
        self.senders = {
            name: Channel(name, stall)
            for name in ("s_axi_aw", "s_axi_w", "s_axi_ar", "m_axil_b", "m_axil_r")
        }
        self.taken_address: deque[int] = deque()
        self.taken_data: deque[tuple[int, int]] = deque()

    def value(self, name: str) -> int:
        return int(getattr(self.dut, name).value)

    def give(self, burst: Burst) -> None:
        address = {
            "id": burst.identity,
            "addr": burst.address,
            "len": burst.beats - 1,
            "size": burst.size,
            "burst": burst.kind,
        }
        self.senders["s_axi_aw" if burst.write else "s_axi_ar"].waiting.append(address)
        last_at = burst.beats - 1 if burst.last_at < 0 else burst.last_at
        for n, (data, strobes) in enumerate(zip(burst.data, burst.strobes, strict=True)):
            self.senders["s_axi_w"].waiting.append(
                {"data": data, "strb": strobes, "last": int(n == last_at)}
            )

    def receive(self, port: str, fields: tuple[str, ...]) -> tuple[int, ...] | None:
        """Set ready at random; return the payload if the next rising edge transfers it, otherwise
        None.

        A valid payload must stay constant until its transfer.
        """
        ready = self.chance.random() >= self.stall
        getattr(self.dut, f"{port}ready").value = int(ready)
        valid = self.value(f"{port}valid")
        held = self.held.pop(port, None)
        if not valid:
            assert held is None, f"{port}valid fell before it was taken"
            return None
        payload = tuple(self.value(port + name) for name in fields)
        assert held in (None, payload), f"{port} changed while it waited: {held} to {payload}"
        if not ready:
            self.held[port] = payload
            return None
        return payload

    def send(self, sender: Channel, name: str) -> None:
        """Drive the next payload; if ready is high, record that the next rising edge transfers
        it."""
        if not sender.valid and sender.waiting and self.chance.random() >= self.stall:
            sender.valid = True
            for part, value in sender.waiting[0].items():
                getattr(self.dut, name + part).value = value
        getattr(self.dut, f"{name}valid").value = int(sender.valid)
        if sender.valid and self.value(f"{name}ready"):
            sender.waiting.popleft()
            sender.valid = False

    async def clock(self) -> None:
        await FallingEdge(self.dut.clock)
        if (answer := self.receive("s_axi_b", ("id", "resp"))) is not None:
            self.write_answers.append((answer[0], answer[1]))
        if (beat := self.receive("s_axi_r", ("id", "resp", "data", "last"))) is not None:
            self.read_beats.append((beat[0], beat[1], beat[2], beat[3]))
        for name, sender in self.senders.items():
            self.send(sender, name)
        if (address := self.receive("m_axil_aw", ("addr",))) is not None:
            self.taken_address.append(address[0])
        if (data := self.receive("m_axil_w", ("data", "strb"))) is not None:
            self.taken_data.append((data[0], data[1]))
        if (read := self.receive("m_axil_ar", ("addr",))) is not None:
            word = read[0]
            self.senders["m_axil_r"].waiting.append(
                {"data": content(word), "resp": answer_of(word)}
            )
        if self.taken_address and self.taken_data:
            word = self.taken_address.popleft()
            self.accesses.append((word, *self.taken_data.popleft()))
            self.senders["m_axil_b"].waiting.append({"resp": answer_of(word)})


ADDRESS_PARTS = ("valid", "id", "addr", "len", "size", "burst")
OUTPUTS_VALID = (
    *("s_axi_bvalid", "s_axi_rvalid"),
    *("m_axil_awvalid", "m_axil_wvalid", "m_axil_arvalid"),
)
INPUTS = (
    *(
        f"s_axi_{c}{p}"
        for c in ("aw", "ar")
        for p in ("valid", "id", "addr", "len", "size", "burst")
    ),
    *("s_axi_wvalid", "s_axi_wdata", "s_axi_wstrb", "s_axi_wlast", "s_axi_bready", "s_axi_rready"),
    *("m_axil_awready", "m_axil_wready", "m_axil_bvalid", "m_axil_bresp"),
    *("m_axil_arready", "m_axil_rvalid", "m_axil_rdata", "m_axil_rresp"),
)


async def reset(dut: Any) -> None:
    await FallingEdge(dut.clock)
    for name in INPUTS:
        getattr(dut, name).value = 0
    dut.reset.value = 1
    for _ in range(3):
        await FallingEdge(dut.clock)
    for name in (
        "s_axi_bvalid",
        "s_axi_rvalid",
        "m_axil_awvalid",
        "m_axil_wvalid",
        "m_axil_arvalid",
    ):
        assert int(getattr(dut, name).value) == 0, f"{name} is high in reset"
    dut.reset.value = 0


async def start(dut: Any) -> None:
    for name in INPUTS:
        getattr(dut, name).value = 0
    dut.reset.value = 1
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    await reset(dut)


async def run(machine: Machine, bursts: list[Burst]) -> None:
    """Play bursts to their end and compare every access, answer and beat."""
    for burst in bursts:
        machine.give(burst)
    writes = [burst for burst in bursts if burst.write]
    reads = [burst for burst in bursts if not burst.write]
    answers = [(burst.identity, expected_write_answer(burst)) for burst in writes]
    beats = [beat for burst in reads for beat in expected_reads(burst)]
    accesses = [access for burst in writes for access in expected_writes(burst)]
    quiet = 0
    while len(machine.write_answers) < len(answers) or len(machine.read_beats) < len(beats):
        before = len(machine.write_answers), len(machine.read_beats)
        await machine.clock()
        quiet = quiet + 1 if before == (len(machine.write_answers), len(machine.read_beats)) else 0
        assert quiet < LONGEST_WAIT, f"no answer in {quiet} clocks after {before}"
    for _ in range(20):
        await machine.clock()
    assert machine.accesses == accesses
    assert machine.write_answers == answers
    assert machine.read_beats == beats


@cocotb.test()
async def every_kind_size_and_length(dut: Any) -> None:
    """Bursts of all sizes, kinds and lengths make the right accesses, with unaligned starts too
    where these are permitted."""
    await start(dut)
    chance = random.Random(1)
    for kind in (FIXED, INCR, WRAP):
        for size in (0, 1, 2):
            bursts = []
            for beats in (2, 4, 8, 16) if kind == WRAP else range(1, 17):
                place = 0x3F0 + (2**size if kind == WRAP else 3)
                for write in (True, False):
                    data = tuple(chance.getrandbits(32) for _ in range(beats))
                    strobes = (15,) * beats
                    bursts.append(
                        Burst(write, beats, BASE + place, beats, size, kind, data, strobes)
                        if write
                        else Burst(write, beats, BASE + place, beats, size, kind)
                    )
            await run(Machine(dut, chance, 0.0), bursts)


@cocotb.test()
async def random_bursts_with_stalls(dut: Any) -> None:
    await start(dut)
    for seed, (stall, count) in enumerate(((0.0, 150), (0.3, 150), (0.7, 60), (0.9, 15))):
        chance = random.Random(seed)
        bursts = [random_burst(chance) for _ in range(count)]
        assert stall > 0.8 or any(burst.refused() for burst in bursts)
        await run(Machine(dut, chance, stall), bursts)


@cocotb.test()
async def reset_in_the_middle(dut: Any) -> None:
    """After a reset in any clock of a burst, the bridge works as after power-up."""
    await start(dut)
    for clocks in range(1, 60, 2):
        chance = random.Random(clocks)
        machine = Machine(dut, chance, 0.2)
        for _ in range(4):
            machine.give(random_burst(chance))
        for _ in range(clocks):
            await machine.clock()
        await reset(dut)
        await run(Machine(dut, chance, 0.2), [random_burst(chance) for _ in range(4)])
