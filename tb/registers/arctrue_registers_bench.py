"""Tests register_access in cocotb: registers on the bus, and the refusal of illegal accesses."""

from __future__ import annotations

import os
import random
from itertools import pairwise

import cocotb
from cocotb.triggers import ClockCycles, FallingEdge, RisingEdge, Timer
from cocotbext.axi import AxiResp

from arctrue.generated import registers as generated
from tb.registers import arctrue_registers_model as model_map
from tb.registers.arctrue_registers_model import RegisterModel, driven_ports
from tb.registers.axi_lite import Bus, start

LANES = 4
CAPTURE_DEPTH = 100
HEADS = int(os.environ.get("HEADS", "2"))
HAS_MEAN = "HEADS" in os.environ
HAS_FAILOVER = "FAILOVER" in os.environ
HAS_LOCAL_TABLE = "LOCAL_TABLE" in os.environ
HAS_REAL_ORDERS = "REAL_ORDERS" in os.environ

ADDRESSES = sorted(
    {
        register.address + 4 * word
        for register in generated.REGISTERS
        for word in range(register.words)
    }
)


LOCAL_PLACES = [
    *(model_map.LOCAL_PLACE + 4 * word for word in range(-1, model_map.LOCAL_PLACE_WORDS + 2)),
    *(
        model_map.LOCAL_POINTS + 4 * word
        for word in (-1, 0, 1, 2047, 2048, model_map.LOCAL_POINT_WORDS - 1)
    ),
    model_map.LOCAL_POINTS + 4 * model_map.LOCAL_POINT_WORDS,
    model_map.LOCAL_POINTS + 0x8000,
]
"""Addresses of points of the local table and of words of ``local_place``, and addresses next to
these."""


TURN_PLACES = [
    *(model_map.TURN_STEPS + 4 * word for word in range(2 * LANES + 2)),
    model_map.TURN_STEPS + 4 * 127,
    *(model_map.TURN_NUMBER + 4 * word for word in (0, 1, 127)),
]
"""Addresses of the turn number, of turn steps (also of lanes that are not built), and addresses
next to these."""


async def prepared(
    dut, generator: random.Random, *, stall: float = 0.0
) -> tuple[Bus, RegisterModel]:
    inputs = dict.fromkeys(driven_ports(), 0)
    for port in inputs:
        getattr(dut, port).value = 0
    dut.interrupt_status.value = 0
    dut.memory_latency.value = 2
    bus = await start(dut)
    if stall:
        bus.stall(generator, stall)
    model = RegisterModel(
        LANES,
        CAPTURE_DEPTH,
        inputs,
        HEADS,
        HAS_MEAN,
        HAS_FAILOVER,
        HAS_LOCAL_TABLE,
        HAS_REAL_ORDERS,
    )
    for latching in (
        *model_map.GROUPS,
        *model_map.WIDE,
    ):  # a first read defines the latched words
        await bus.read(latching)
        model.read(latching)
    # Coefficients and other words survive a reset, so an earlier test may have left values.
    await bus.write(model_map.OFFSET, 0)
    await bus.write_words(model_map.COEFFICIENTS, [0] * (4 * LANES))
    for word in range(16):
        if model.mean_exists(model_map.MEAN + 4 * word):
            await bus.write(model_map.MEAN + 4 * word, 0)
    for address in model.heads_words(write=True):
        await bus.write(address, 0)
    for address in set_places():
        if model.set_word_exists(address):
            await bus.write(address, 0)
    for address in LOCAL_PLACES:
        if model.local_word_exists(address):
            await bus.write(address, 0)
    for address in TURN_PLACES:
        if model.turn_step_exists(address):
            await bus.write(address, 0)
    return bus, model


def change_inputs(dut, generator: random.Random, model: RegisterModel) -> None:
    for port, width in driven_ports().items():
        model.inputs[port] = generator.getrandbits(width)
        getattr(dut, port).value = model.inputs[port]


def set_places() -> list[int]:
    """Return addresses of words of every prepared set, in gaps of the sets, and in one set beyond
    the last."""
    words = [*range(4 * LANES + 2), 0x100, *range(0x1FE, 0x212), 0x3FF]
    return [
        model_map.PREPARED_SETS + model_map.SET_BYTES * number + 4 * word
        for number in range(6)
        for word in words
    ]


def random_address(generator: random.Random) -> int:
    """Return a random address: of a register, in a gap between registers, in a window, or beyond a
    window's end."""
    kind = generator.randrange(15)
    if kind < 5:
        return generator.choice(ADDRESSES)
    if kind == 5:
        return 4 * generator.randrange(0x400)
    if kind == 6:
        return model_map.COEFFICIENTS + 4 * generator.randrange(4 * LANES + 8)
    if kind == 7:
        return model_map.CAPTURE + 4 * generator.randrange(2 * CAPTURE_DEPTH + 20)
    if kind == 8:
        return model_map.CAPTURE + 4 * generator.randrange(model_map.CAPTURE_WORDS)
    if kind == 9:
        return 4 * generator.randrange(70) + generator.choice(
            [model_map.MEAN, model_map.HEADS, model_map.CONDITIONS]
        )
    if kind == 10:
        return model_map.FURTHER_CAPTURE + 4 * generator.randrange(2 * CAPTURE_DEPTH + 20)
    if kind == 11:
        return generator.choice(set_places())
    if kind == 12:
        return generator.choice(LOCAL_PLACES)
    if kind == 13:
        return generator.choice(TURN_PLACES)
    return 4 * generator.randrange(1 << 17)


@cocotb.test()
async def random_accesses_as_the_model(dut):
    """The answers to 3,000 legal and illegal accesses, with byte strobes and stalls, equal the
    model's."""
    generator = random.Random(10)
    bus, model = await prepared(dut, generator, stall=0.3)
    refused = accepted = 0
    for _ in range(3000):
        if generator.random() < 0.2:
            change_inputs(dut, generator, model)
        if generator.random() < 0.1:
            dut.memory_latency.value = generator.randint(1, 9)
        address = random_address(generator)
        if generator.random() < 0.5:
            word = generator.getrandbits(32)
            strobes = generator.choice([0b1111, 0b1111, 0b1111, 0b0001, 0b0110, 0b1100, 0b1000])
            expected = model.write(address, word, strobes)
            answer = await bus.write(address, word, strobes)
            found = f"write 0x{word:08X} strobes {strobes:04b}"
        else:
            expected, word = model.read(address)
            answer, read = await bus.read(address)
            found = f"read 0x{read:08X}, model 0x{word:08X}"
            assert read == word, f"0x{address:05X}: {found}"
        assert answer == (AxiResp.OKAY if expected else AxiResp.SLVERR), (
            f"0x{address:05X}: {answer!r}, model {'accepts' if expected else 'refuses'}: {found}"
        )
        accepted += expected
        refused += not expected
        for place, (_, _, port) in model_map.READ_WRITE.items():
            if port:
                assert int(getattr(dut, port).value) == model.values[place], port
    assert min(accepted, refused) > 500, (accepted, refused)


@cocotb.test()
async def every_word_of_the_map(dut):
    """The answers to accesses of every register word and coefficient word, and at the ends of the
    windows, equal the model's."""
    generator = random.Random(11)
    bus, model = await prepared(dut, generator)
    change_inputs(dut, generator, model)
    model.inputs["status"] |= model_map.CAPTURE_READY
    dut.status.value = model.inputs["status"]
    places = [4 * word for word in range(0x400 + 256 + 8)]
    places += [model_map.CAPTURE + 4 * word for word in (0, 1, 2 * CAPTURE_DEPTH - 1)]
    places += [model_map.CAPTURE + 4 * word for word in (2 * CAPTURE_DEPTH, 32767)]
    places += [model_map.CAPTURE - 4]
    places += [model_map.MEAN + 4 * word for word in range(-1, 17)]
    places += [model_map.CONDITIONS + 4 * word for word in range(17)]
    places += [model_map.HEADS + 4 * word for word in range(-1, 65)]
    places += [*set_places(), *LOCAL_PLACES, *TURN_PLACES]
    places += [model_map.FURTHER_CAPTURE + 4 * word for word in (0, 1, 2 * CAPTURE_DEPTH)]
    for address in places:
        expected, word = model.read(address)
        answer, read = await bus.read(address)
        assert (answer == AxiResp.OKAY, read) == (expected, word), (
            f"read 0x{address:05X}: {answer!r}"
        )
        word = generator.getrandbits(32)
        expected = model.write(address, word, 0b1111)
        answer = await bus.write(address, word)
        assert (answer == AxiResp.OKAY) == expected, f"write 0x{address:05X}: {answer!r}"


@cocotb.test()
async def capture_needs_a_ready_bank(dut):
    bus, model = await prepared(dut, random.Random(12))
    for ready in (0, model_map.CAPTURE_READY, 0):
        model.inputs["status"] = ready
        dut.status.value = ready
        answer, word = await bus.read(model_map.CAPTURE + 8)
        expected = (AxiResp.OKAY, 0xFFFD0002) if ready else (AxiResp.SLVERR, 0)
        assert (answer, word) == expected


@cocotb.test()
async def commands_act_for_one_clock(dut):
    bus, _ = await prepared(dut, random.Random(13))
    counts = [0] * 9

    async def watch():
        while True:
            await FallingEdge(dut.clock)
            value = int(dut.command.value)
            for bit in range(9):
                counts[bit] += value >> bit & 1

    cocotb.start_soon(watch())
    for word in (0b1, 0b11010101, 0b0, 0b111111111):
        assert await bus.write(model_map.COMMAND, word) == AxiResp.OKAY
    await ClockCycles(dut.clock, 3)
    assert counts == [3, 1, 2, 1, 2, 1, 2, 2, 1]
    answer, _ = await bus.read(model_map.COMMAND)
    assert answer == AxiResp.SLVERR


@cocotb.test()
async def snapshot_is_one_clock(dut):
    """All values of a snapshot come from one clock, although the inputs change in every clock and
    the reads stall."""
    generator = random.Random(14)
    bus, _ = await prepared(dut, generator, stall=0.4)
    parts = {port: (width, generator.getrandbits(24)) for port, width in driven_ports().items()}

    async def drive():
        # The low 24 bits of every port are the number of the clock plus a constant of the port; a
        # 64-bit port repeats them in its high word.
        clock = 0
        while True:
            await RisingEdge(dut.clock)
            clock += 1
            for port, (width, constant) in parts.items():
                if port.startswith("snapshot") or width == 64:
                    value = (clock + constant) & 0xFFFFFF
                    getattr(dut, port).value = value | value << 32 if width == 64 else value

    cocotb.start_soon(drive())
    registers = bus.registers()
    await ClockCycles(dut.clock, 5)
    last = -1
    for _ in range(25):
        clocks = set()
        for register in generated.REGISTERS:
            if register.path.startswith("snapshot."):
                word = await registers.read_raw(register.path)
                port = register.path.replace(".", "_")
                for half in [word & model_map.WORD, word >> 32][: register.words]:
                    clocks.add((half - parts[port][1]) & 0xFFFFFF)
        assert len(clocks) == 1, f"values of {sorted(clocks)} mixed in one snapshot"
        assert clocks.pop() != last
        for path in ("head1.index", "head2.index", "capture_header.start_time"):
            word = await registers.read_raw(path)
            assert word >> 32 == word & model_map.WORD, f"{path} is torn: 0x{word:016X}"


@cocotb.test()
async def bursts_keep_their_order(dut):
    """Reads of the capture and simultaneous writes of coefficients keep their order in spite of
    stalls."""
    generator = random.Random(15)
    bus, _ = await prepared(dut, generator, stall=0.4)
    dut.status.value = model_map.CAPTURE_READY
    written: dict[int, int] = {}

    async def write_coefficients():
        for _ in range(3):
            for word in range(4 * LANES):
                address = model_map.COEFFICIENTS + 4 * word
                written[address] = generator.getrandbits(32)
                assert await bus.write(address, written[address]) == AxiResp.OKAY

    writer = cocotb.start_soon(write_coefficients())
    for latency in (1, 2, 3, 7, 2):
        dut.memory_latency.value = latency
        words = await bus.read_words(model_map.CAPTURE, 2 * CAPTURE_DEPTH)
        assert words == [(~word & 0xFFFF) << 16 | word for word in range(2 * CAPTURE_DEPTH)]
    await writer
    for address, word in written.items():
        assert await bus.read(address) == (AxiResp.OKAY, word)


@cocotb.test()
async def answers_after_their_clocks_in_turn(dut):
    """Each answer comes after the number of clocks that the headers of register_access and
    axi_lite_access state."""
    bus, _ = await prepared(dut, random.Random(20))
    seen: list[dict[str, int]] = []
    names = ("awvalid", "wvalid", "arvalid", "bvalid", "rvalid")

    async def watch():
        while True:
            await FallingEdge(dut.clock)
            seen.append({name: int(getattr(dut, f"s_axil_{name}").value) for name in names})

    def clocks_from(asked: tuple[str, ...], answer: str) -> int:
        first = next(n for n, now in enumerate(seen) if all(now[name] for name in asked))
        return next(n for n, now in enumerate(seen) if now[answer]) - first

    cocotb.start_soon(watch())
    await bus.read(0x010)
    assert clocks_from(("arvalid",), "rvalid") == 4
    seen.clear()
    await bus.write(0x010, 1)
    assert clocks_from(("awvalid", "wvalid"), "bvalid") == 3
    seen.clear()
    await bus.read(generated.COEFFICIENTS_ADDRESS + 16 * LANES)
    assert clocks_from(("arvalid",), "rvalid") == 3, "time of a refused access"

    seen.clear()
    first, words = 0x030, 7  # registers filter_length to following_limit
    reads = cocotb.start_soon(bus.read_words(first, words))
    answer = await bus.master.write(first, bytes(4 * words))
    assert answer.resp == AxiResp.OKAY
    await reads
    kinds = "".join("w" * now["bvalid"] + "r" * now["rvalid"] for now in seen)
    assert kinds in ("wr" * words, "rw" * words), f"answers came as {kinds}"
    clocks = [n for n, now in enumerate(seen) if now["bvalid"] or now["rvalid"]]
    # Reads and writes alternate. The time from one answer to the next is one clock longer than the
    # later access takes alone.
    assert {later - earlier for earlier, later in pairwise(clocks)} == {4, 5}


@cocotb.test()
async def interrupts_set_enable_and_clear(dut):
    bus, _ = await prepared(dut, random.Random(16))
    # The source of some bits is a level, whose rising edge sets the bit; strobes set the other
    # bits.
    for bit in range(16):
        dut.interrupt_status.value = 1 << bit
        await ClockCycles(dut.clock, 1)
        if bit not in (4, 5, 8, 9, 13, 14):
            dut.interrupt_status.value = 0
        await ClockCycles(dut.clock, 3)
        assert await bus.read(model_map.INTERRUPT_STATUS) == (AxiResp.OKAY, 1 << bit)
        assert int(dut.interrupt.value) == 0, "the line rose without an enable"
        await bus.write(0x0A0, 1 << bit)
        await ClockCycles(dut.clock, 2)
        assert int(dut.interrupt.value) == 1
        await bus.write(0x0A0, model_map.INTERRUPT_MASK & ~(1 << bit))
        await ClockCycles(dut.clock, 2)
        assert int(dut.interrupt.value) == 0, "the line follows another bit's enable"
        await bus.write(0x0A0, model_map.INTERRUPT_MASK)
        await bus.write(model_map.INTERRUPT_STATUS, model_map.INTERRUPT_MASK & ~(1 << bit))
        await ClockCycles(dut.clock, 2)
        assert int(dut.interrupt.value) == 1, "cleared by the writing of other bits"
        await bus.write(model_map.INTERRUPT_STATUS, 1 << bit)
        await ClockCycles(dut.clock, 3)
        assert int(dut.interrupt.value) == 0, "a level set the bit again"
        dut.interrupt_status.value = 0
        await bus.write(0x0A0, 0)


@cocotb.test()
async def no_event_is_lost_in_the_clock_of_its_clear(dut):
    """An event that comes in the clock of its clear stays set; the event comes at another clock in
    each run.

    If the event comes before the clear, the interrupt line is low at the end. If it comes after the
    clear, the line falls and rises again. The line stays high only if the event comes in the clock
    of the clear; this must happen in exactly one run. If the clear had priority, the line would
    stay high in no run.
    """
    bus, _ = await prepared(dut, random.Random(17))
    await bus.write(0x0A0, 1)
    kept = []
    for delay in range(25):
        dut.interrupt_status.value = 1
        await ClockCycles(dut.clock, 1)
        dut.interrupt_status.value = 0
        await ClockCycles(dut.clock, 3)
        fell = False
        clear = cocotb.start_soon(bus.write(model_map.INTERRUPT_STATUS, 1))
        for clock in range(30):
            dut.interrupt_status.value = int(clock == delay)
            await RisingEdge(dut.clock)
            await Timer(1, "ns")
            fell |= int(dut.interrupt.value) == 0
        await clear
        if int(dut.interrupt.value) == 1 and not fell:
            kept.append(delay)
        await bus.write(model_map.INTERRUPT_STATUS, 1)
        await ClockCycles(dut.clock, 3)
    assert len(kept) == 1, f"the line stayed high through the clear for delays {kept}"


@cocotb.test()
async def reset_restores_every_register(dut):
    generator = random.Random(18)
    bus, _ = await prepared(dut, generator)
    for address in model_map.READ_WRITE:
        await bus.write(address, generator.getrandbits(32))
    dut.interrupt_status.value = model_map.INTERRUPT_MASK
    await ClockCycles(dut.clock, 2)
    dut.interrupt_status.value = 0
    dut.reset.value = 1
    await ClockCycles(dut.clock, 3)
    dut.reset.value = 0
    await ClockCycles(dut.clock, 3)
    for address, (_, reset, _) in model_map.READ_WRITE.items():
        assert await bus.read(address) == (AxiResp.OKAY, reset), f"0x{address:05X}"
    assert await bus.read(model_map.INTERRUPT_STATUS) == (AxiResp.OKAY, 0)


@cocotb.test()
async def named_access(dut):
    """The Python class RegisterMap reads and writes registers by name over the bus."""
    bus, _ = await prepared(dut, random.Random(19))
    registers = bus.registers()
    dut.core_configuration.value = 4 | 18 << 8 | 100 << 16
    found = await registers.check_identity()
    assert found == {"lanes": 4, "cosine_width": 18, "capture_depth": 100}
    await registers.update("control", compensate=1, capture_mode=1)
    await registers.update("control", output_enable=1, capture_mode=0)
    await ClockCycles(dut.clock, 2)
    assert int(dut.control.value) == 0b0011
    dut.snapshot_time.value = 5_000_000_000
    dut.snapshot_head1_position.value = (-7) & model_map.WORD
    dut.snapshot_correction.value = (-2048) & model_map.WORD
    snapshot = await registers.snapshot()
    assert (snapshot.time, snapshot.head1_position, snapshot.correction) == (
        5_000_000_000,
        -7,
        -2048,
    )
    await registers.write("coefficient_offset", -12)
    assert await registers.read("coefficient_offset") == -12
