"""Runs the core with moving encoders and a busy processor; records all inputs and outputs."""

from __future__ import annotations

import json
import os
import random
from collections.abc import Iterator
from pathlib import Path

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge

from arctrue.gateware.register_access import register_named
from arctrue.generated.number_formats import HEADS_MAX
from arctrue.generated.registers import (
    CAPTURE_ADDRESS,
    COEFFICIENTS_ADDRESS,
    FURTHER_CAPTURE_ADDRESS,
    MAP_BYTES,
    MEAN_ADDRESS,
    REGISTERS,
)

CLOCKS = int(os.environ.get("ARCTRUE_EQUAL_CLOCKS", "6000"))
LANES = int(os.environ["ARCTRUE_LANES"])
HEADS = int(os.environ["ARCTRUE_HEADS"])
HAS_FURTHER = HEADS > 2
COUNTS_PER_REV = 64
CHANNELS = ("aw", "w", "ar")
GIVEN = ("awvalid", "wvalid", "arvalid", "bready", "rready")
SAID = ("awready", "wready", "arready", "bvalid", "rvalid")

CONTROLS = (0b00111, 0b01111, 0b10111, 0b00110, 0b00101)
"""Control words: captures at equal times, at equal angles and on request, and two words that
disable the correction or the output."""
ABSENT_HEADS = {f"head{head}_{pin}": 0 for head in range(HEADS + 1, HEADS_MAX + 1) for pin in "abz"}
"""Pins of the heads beyond HEADS, which stay low."""
DNA = {"chip_dna": 0x0AB_CDEF_0123_4567, "chip_dna_known": 1}
"""Ports for the chip's identifier, which on the chip comes from a primitive of the top level."""
COMMANDS = (
    "clear_head1",
    "clear_head2",
    "clear_output",
    "swap",
    "compare_arm",
    "compare_disarm",
    "alive",
)

LATCHES = (*(f"head{head}.index" for head in range(1, HEADS + 1)), "snapshot.time", "probe.time")
"""Registers whose low word latches the other words of their group when it is read."""

Access = tuple[bool, int, int, int]
"""Access of the processor: a flag that is true for a write, the address, the word and the
strobes."""


def address(path: str) -> int:
    return register_named(path).address


def command(*names: str) -> Access:
    register = register_named("command")
    return True, register.address, sum(register.field(name).mask for name in names), 15


def set_up() -> Iterator[Access]:
    """Yield the accesses that set up the core for a short turn; the re-arm takes 128 clocks."""
    for path, word in (
        ("counts_per_rev", COUNTS_PER_REV),
        ("sample_period", 9),
        ("ramp_rate", 200 << 24),
        ("ramp_acceleration", 2**32 - 1),
        ("output_spacing", 1),
        ("minimum_edge_spacing", 4),
        ("interrupt_enable", 0x7FFF if HAS_FURTHER else 0x7FF),
        ("pulse_widths", 3 << 16 | 2),
        # The table reaches this place during the 40 reads below, before a random access can disarm
        # the position compare.
        ("compare.first", 40),
        ("compare.interval", 8),
    ):
        yield True, address(path), word, 15
    if HAS_FURTHER:
        yield True, address("head_delays"), 0x05_00_01_02, 15
    yield command("rearm", "clear_head1", "clear_head2", "compare_arm")
    yield from [(False, address("scratch"), 0, 0)] * 40
    yield True, address("control"), 0b0111, 15


def coefficients(draw: random.Random) -> Iterator[Access]:
    step = 2**48 // COUNTS_PER_REV
    for lane in range(LANES + 1):  # The last lane does not exist.
        words = (
            (lane + 1) * step & 0xFFFF_FFFF,
            (lane + 1) * step >> 32,
            draw.getrandbits(24),
            draw.randrange(-3 << 11, 3 << 11) & 0xFFFF_FFFF,
        )
        for place, word in enumerate(words):
            yield True, COEFFICIENTS_ADDRESS + 16 * lane + 4 * place, word, 15
    yield True, address("coefficient_offset"), draw.randrange(-4096, 4096) & 0xFFFF_FFFF, 15
    yield False, COEFFICIENTS_ADDRESS + 12, 0, 0
    if HAS_FURTHER:
        yield from mean_words(draw)
    yield command("swap")


def mean_words(draw: random.Random) -> Iterator[Access]:
    """Yield the writes of all words of the mean: offsets, weights, carrier and used heads."""
    offsets = [draw.randrange(COUNTS_PER_REV << 4) for _ in range(HEADS_MAX)]
    weights = [draw.randrange(-(2**14), 2**15) & 0xFFFF_FFFF for _ in range(HEADS_MAX)]
    carrier = draw.randrange(HEADS)
    used = draw.getrandbits(HEADS) | 1 << carrier
    for place, word in enumerate((*offsets, *weights, used << 4 | carrier)):
        yield True, MEAN_ADDRESS + 4 * place, word, 15


def accesses(draw: random.Random) -> Iterator[Access]:
    """Yield legal and illegal accesses of a processor without end."""
    yield from set_up()
    yield from coefficients(draw)
    # A reset does not clear latched words: until the first read that latches them they have values
    # from before the reset.
    for path in LATCHES:
        yield False, address(path), 0, 0
    while True:
        kind = draw.random()
        if kind < 0.5:
            register = draw.choice(REGISTERS)
            for word in range(register.words):
                yield False, register.address + 4 * word, 0, 0
        elif kind < 0.7:
            capture = draw.choice((CAPTURE_ADDRESS, FURTHER_CAPTURE_ADDRESS)[: 1 + HAS_FURTHER])
            for place in range(draw.randrange(1, 34)):
                yield False, capture + 4 * place, 0, 0
            yield command("capture_release")
        elif kind < 0.76:
            yield from coefficients(draw)
        elif kind < 0.82:
            yield True, address("control"), draw.choice(CONTROLS), 15
        elif kind < 0.88:
            yield True, address("interrupt_status"), draw.getrandbits(11), draw.getrandbits(4)
        elif kind < 0.94:
            yield draw.random() < 0.5, draw.randrange(0, MAP_BYTES), draw.getrandbits(32), 15
        elif kind < 0.97:
            yield command(*draw.sample(COMMANDS, 2))
            if HAS_FURTHER:
                yield True, address("heads_command"), draw.randrange(4), 15
        else:
            yield True, address(draw.choice(("angle_step", "sample_period"))), 5, 15


class Master:
    """Simulates a bus master that makes one access at a time and stalls every channel at random."""

    def __init__(self, draw: random.Random) -> None:
        self.draw = draw
        self.waiting = accesses(draw)
        self.pending: set[str] = set()
        self.inputs = {
            f"s_axil_{name}": 0
            for name in (
                *("awvalid", "awaddr", "wvalid", "wdata", "wstrb"),
                *("bready", "arvalid", "araddr", "rready"),
            )
        }

    def next_clock(self, accepted: dict[str, bool]) -> None:
        """Set the inputs of the next clock; ``accepted`` has the channels with a handshake in the
        previous clock."""
        given = self.inputs
        for channel in CHANNELS:
            if accepted.get(channel):
                given[f"s_axil_{channel}valid"] = 0
                self.pending.discard(channel)
        if accepted.get("answer"):
            self.pending.discard("answer")
        if not self.pending:
            write, where, word, strobe = next(self.waiting)
            self.pending = {"aw", "w", "answer"} if write else {"ar", "answer"}
            if write:
                given.update(s_axil_awaddr=where, s_axil_wdata=word, s_axil_wstrb=strobe)
            else:
                given["s_axil_araddr"] = where
        for channel in self.pending - {"answer"}:
            if self.draw.random() < 0.6:
                given[f"s_axil_{channel}valid"] = 1
        ready = int(self.draw.random() < 0.7)
        given.update(s_axil_bready=ready, s_axil_rready=ready)


class Heads:
    """Simulates encoders that move up and down over their index marks; now and then A and B have
    wrong levels."""

    def __init__(self, draw: random.Random) -> None:
        self.draw = draw
        self.position = [-20.0, -14.0, -17.0, -9.0][:HEADS]
        self.speed = 0.25

    def next_clock(self) -> dict[str, int]:
        if self.draw.random() < 0.0008:
            self.speed = self.draw.choice((-0.25, 0.25, 0.25, 0.5))
        pins = {}
        for head in range(1, HEADS + 1):
            self.position[head - 1] += self.speed * self.draw.uniform(0.8, 1.2)
            count = int(self.position[head - 1] // 1)
            levels = (0b00, 0b01, 0b11, 0b10)[count % 4]
            if self.draw.random() < 0.001:
                levels ^= self.draw.randrange(4)
            pins |= {
                f"head{head}_a": levels & 1,
                f"head{head}_b": levels >> 1,
                f"head{head}_z": int(count % COUNTS_PER_REV == 0),
            }
        return pins


class ExternalInstruments:
    """Simulates external instruments by random edges of sync_in and probe_in."""

    def __init__(self, draw: random.Random) -> None:
        self.draw = draw
        self.pins = {"sync_in": 0, "probe_in": 0}

    def next_clock(self) -> dict[str, int]:
        for name in self.pins:
            if self.draw.random() < 0.05:
                self.pins[name] ^= 1
        return self.pins


@cocotb.test()
async def note_everything(dut) -> None:
    folder = Path(os.environ["ARCTRUE_EQUAL_FOLDER"])
    draw = random.Random(int(os.environ.get("ARCTRUE_EQUAL_SEED", "1")))
    master, heads, instruments = Master(draw), Heads(draw), ExternalInstruments(draw)
    from_netlist = json.loads((folder / "outputs.json").read_text(encoding="utf-8"))
    outputs = [getattr(dut, name) for name in from_netlist]
    constants = ABSENT_HEADS | DNA
    names = ["reset", *master.inputs, *heads.next_clock(), *instruments.next_clock(), *constants]
    drivers = [getattr(dut, name) for name in names]
    inputs: list[list[int]] = []
    noted: list[list[str]] = []
    last: list[int | None] = [None] * len(names)
    accepted: dict[str, bool] = {}
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    await FallingEdge(dut.clock)
    for clock in range(CLOCKS):
        reset = int(clock < 80 or CLOCKS // 2 <= clock < CLOCKS // 2 + 80)
        if reset:
            # During a reset the bus is idle; a new master, without the current access, replaces the
            # old one.
            master = Master(draw)
        else:
            master.next_clock(accepted)
        pins = heads.next_clock() | instruments.next_clock()
        row = list({"reset": reset, **master.inputs, **pins, **constants}.values())
        for place, value in enumerate(row):
            if value != last[place]:
                drivers[place].value = value
        last = list(row)
        inputs.append(row)
        await RisingEdge(dut.clock)
        # These are the levels before the rising edge, which the edge samples.
        levels = {name: str(getattr(dut, f"s_axil_{name}").value) == "1" for name in SAID}
        given = {name: bool(master.inputs[f"s_axil_{name}"]) for name in GIVEN}
        accepted = {
            channel: given[f"{channel}valid"] and levels[f"{channel}ready"] for channel in CHANNELS
        }
        accepted["answer"] = any(levels[f"{name}valid"] and given[f"{name}ready"] for name in "br")
        await FallingEdge(dut.clock)
        noted.append([str(output.value) for output in outputs])
    for name, header, rows in (("inputs", names, inputs), ("noted", from_netlist, noted)):
        columns = dict(zip(header, zip(*rows, strict=True), strict=True))
        (folder / f"{name}.json").write_text(json.dumps(columns), encoding="utf-8")
