"""Defines the delays of the cells of the 7 series, and the pins at which a path begins and ends.

The delays are the ones that Yosys states for its cells (``share/yosys/xilinx/cells_sim.v``), which
come from the Artix-7 data of Project X-Ray. Where they differ from pin to pin, the mean or the
largest is used. Wire delays are guesses, because nothing is placed: 0.4 ns, plus 0.1 ns for each
doubling of the fan-out. The results are estimates that can rank paths, but cannot prove that the
timing is met.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import Any, Final

WIRE_NS: Final = 0.4
WIRE_DOUBLING_NS: Final = 0.1

FLIP_FLOP: Final = re.compile(r"FD[RSCP]E(_1)?")
LUT: Final = re.compile(r"LUT[1-6]|INV")
LUT_RAM: Final = re.compile(r"RAM\d+(X1[SD]|M)(_1)?")
BLOCK_RAM: Final = re.compile(r"RAMB(18|36)E1")
SHIFT_REGISTER: Final = re.compile(r"SRL(16E|C32E)")
WIRES_ONLY: Final = ("IBUF", "OBUF", "BUFG", "IOBUF", "OBUFT", "IBUFDS", "OBUFDS")

LUT_NS: Final = 0.35
MULTIPLEXER_NS: Final = 0.25  # MUXF7, MUXF8
FLIP_FLOP_OUT_NS: Final = 0.30
SETUP_NS: Final = {"D": 0.0, "CE": 0.11, "R": 0.40, "S": 0.40, "CLR": 0.40, "PRE": 0.40}

CARRY_THROUGH_NS: Final = 0.11  # CI to CO[3]
CARRY_IN_TO_SUM_NS: Final = 0.32
CARRY_IN_TO_CARRY_NS: Final = 0.22
CARRY_ENTER_NS: Final = 0.53  # S, DI or CYINIT to CO
CARRY_BIT_NS: Final = 0.45  # S, DI or CYINIT to O

SHIFT_REGISTER_OUT_NS: Final = 1.47
LUT_RAM_OUT_NS: Final = 1.15
MEMORY_SETUP_NS: Final = 0.25
BLOCK_RAM_OUT_NS: Final = 2.45
BLOCK_RAM_REGISTERED_OUT_NS: Final = 0.88
BLOCK_RAM_SETUP_NS: Final = 0.74

DSP_PORT_REGISTER_SETUP_NS: Final = 0.25
DSP_MULTIPLY_SETUP_NS: Final = 2.40  # port to product register
DSP_ADD_SETUP_NS: Final = 1.31  # C or PCIN to sum register
DSP_MULTIPLY_ADD_SETUP_NS: Final = 3.70  # port to sum register
DSP_OUT_NS: Final = 0.33  # sum register to P
DSP_ADD_OUT_NS: Final = 1.67  # product register to P
DSP_MULTIPLY_ADD_OUT_NS: Final = 2.95  # port register to P
DSP_ADD_THROUGH_NS: Final = 1.52  # C or PCIN to P without a register
DSP_MULTIPLY_THROUGH_NS: Final = 3.9


@dataclass(frozen=True)
class Arc:
    """Path between two bits of a cell; ``levels`` and ``multipliers`` are the numbers of LUTs and
    DSPs on the path."""

    start: int
    end: int
    delay_ns: float
    levels: int = 0
    multipliers: int = 0
    is_carry_entry: bool = False
    """Whether the path leads from a LUT or a register into a carry chain."""
    is_direct: bool = False
    """Whether the path's input comes from a neighbour in the slice and needs no wire."""


@dataclass(frozen=True)
class Pin:
    """Start of a path, ``delay_ns`` after the clock edge, or end of a path, ``delay_ns`` before the
    clock edge."""

    bit: int
    delay_ns: float
    multipliers: int = 0


@dataclass
class CellTiming:
    """Starts, ends and arcs that one cell adds to the paths of a netlist."""

    begins: list[Pin] = field(default_factory=list)
    ends: list[Pin] = field(default_factory=list)
    arcs: list[Arc] = field(default_factory=list)


def wire_ns(fan_out: int) -> float:
    """Estimate the delay of a net that drives ``fan_out`` inputs."""
    return WIRE_NS + WIRE_DOUBLING_NS * math.log2(max(fan_out, 1))


def _bits(cell: dict[str, Any], port: str) -> list[int]:
    """Return the numbers of the nets at a port; leave out constants, which Yosys writes as
    texts."""
    return [bit for bit in cell["connections"].get(port, []) if isinstance(bit, int)]


def _ports(cell: dict[str, Any], direction: str) -> list[str]:
    given = cell.get("port_directions", {})
    return [port for port in cell["connections"] if given.get(port) == direction]


def _parameter(cell: dict[str, Any], name: str) -> int:
    value = str(cell.get("parameters", {}).get(name, "0"))
    return int(value, 2) if set(value) <= {"0", "1"} else 0


def _clocked(cell: dict[str, Any], out_ns: float, setup_ns: float) -> CellTiming:
    """Return the timing of a clocked cell: paths end at all its inputs except the clock, and begin
    at all its outputs."""
    timing = CellTiming()
    for port in _ports(cell, "output"):
        timing.begins += [Pin(bit, out_ns) for bit in _bits(cell, port)]
    for port in _ports(cell, "input"):
        if not re.search(r"CLK|^C$", port):
            setup = SETUP_NS.get(port, setup_ns)
            timing.ends += [Pin(bit, setup) for bit in _bits(cell, port)]
    return timing


def _through(cell: dict[str, Any], delay_ns: float, levels: int) -> CellTiming:
    """Return the timing of a combinational cell: a path leads from every input to every output."""
    arcs = [
        Arc(start, end, delay_ns, levels)
        for source in _ports(cell, "input")
        for start in _bits(cell, source)
        for target in _ports(cell, "output")
        for end in _bits(cell, target)
    ]
    return CellTiming(arcs=arcs)


def _wide_multiplexer(cell: dict[str, Any]) -> CellTiming:
    """Return the timing of a multiplexer of two LUTs of the slice, or of two multiplexers.

    The wire to the multiplexer's select input adds a delay.
    """
    arcs = [
        Arc(start, end, MULTIPLEXER_NS, is_direct=port != "S")
        for port in ("I0", "I1", "S")
        for start in _bits(cell, port)
        for end in _bits(cell, "O")
    ]
    return CellTiming(arcs=arcs)


def _carry(cell: dict[str, Any]) -> CellTiming:
    timing = CellTiming()
    connections = cell["connections"]
    for place in range(4):
        for port, enter, through in (
            ("O", CARRY_BIT_NS, CARRY_IN_TO_SUM_NS),
            ("CO", CARRY_ENTER_NS, CARRY_THROUGH_NS if place == 3 else CARRY_IN_TO_CARRY_NS),
        ):
            bits = connections.get(port, [])
            if place >= len(bits) or not isinstance(bits[place], int):
                continue
            end = bits[place]
            timing.arcs += [Arc(bit, end, through) for bit in _bits(cell, "CI")]
            entries = _bits(cell, "CYINIT")
            # DI of a stage changes the carries from this stage on, but not the sum of this stage.
            below = {"S": place + 1, "DI": place + (port == "CO")}
            for source, count in below.items():
                entries += [
                    bit for bit in connections.get(source, [])[:count] if isinstance(bit, int)
                ]
            timing.arcs += [Arc(bit, end, enter, is_carry_entry=True) for bit in entries]
    return timing


def _multiplier(cell: dict[str, Any]) -> CellTiming:
    """Return the timing of a DSP.

    The DSP's registers determine where paths begin and end; a multiplication and an addition each
    add a delay.
    """
    timing = CellTiming()
    is_added = bool(_parameter(cell, "PREG"))
    is_multiplied = bool(_parameter(cell, "MREG"))
    outputs = _bits(cell, "P") + _bits(cell, "PCOUT")
    if is_added:
        timing.begins += [Pin(bit, DSP_OUT_NS) for bit in outputs]
    elif is_multiplied:
        timing.begins += [Pin(bit, DSP_ADD_OUT_NS, 1) for bit in outputs]
    elif _parameter(cell, "AREG") or _parameter(cell, "BREG"):
        timing.begins += [Pin(bit, DSP_MULTIPLY_ADD_OUT_NS, 1) for bit in outputs]
    for port, register in (("A", "AREG"), ("B", "BREG"), ("D", "DREG")):
        for bit in _bits(cell, port):
            if _parameter(cell, register):
                timing.ends.append(Pin(bit, DSP_PORT_REGISTER_SETUP_NS))
            elif is_multiplied:
                timing.ends.append(Pin(bit, DSP_MULTIPLY_SETUP_NS, 1))
            elif is_added:
                timing.ends.append(Pin(bit, DSP_MULTIPLY_ADD_SETUP_NS, 1))
            else:
                timing.arcs += [
                    Arc(bit, end, DSP_MULTIPLY_THROUGH_NS, multipliers=1) for end in outputs
                ]
    for port, register in (("C", "CREG"), ("PCIN", "")):
        for bit in _bits(cell, port):
            if register and _parameter(cell, register):
                timing.ends.append(Pin(bit, DSP_PORT_REGISTER_SETUP_NS))
            elif is_added:
                timing.ends.append(Pin(bit, DSP_ADD_SETUP_NS, 1))
            else:
                timing.arcs += [Arc(bit, end, DSP_ADD_THROUGH_NS, multipliers=1) for end in outputs]
    for port in _ports(cell, "input"):
        if port.startswith(("CE", "RST")):
            timing.ends += [Pin(bit, SETUP_NS["R"]) for bit in _bits(cell, port)]
    return timing


def _lut_ram(cell: dict[str, Any]) -> CellTiming:
    """Return the timing of a LUT as RAM, in which writes are clocked and reads are not."""
    written = [port for port in _ports(cell, "input") if re.match(r"DI|D$|WE|ADDRD$", port)]
    timing = _clocked(cell, LUT_RAM_OUT_NS, MEMORY_SETUP_NS)
    addresses = [
        bit
        for port in _ports(cell, "input")
        if port not in written and not port.startswith("WCLK")
        for bit in _bits(cell, port)
    ]
    outputs = [bit for port in _ports(cell, "output") for bit in _bits(cell, port)]
    timing.arcs = [Arc(start, end, LUT_NS, 1) for start in addresses for end in outputs]
    return timing


def timing_of(cell: dict[str, Any]) -> CellTiming:
    """Return starts, ends and arcs of a cell in Yosys' JSON. Raises ValueError for an unknown
    cell."""
    kind = str(cell["type"]).removeprefix("\\")
    if FLIP_FLOP.fullmatch(kind):
        return _clocked(cell, FLIP_FLOP_OUT_NS, 0.0)
    if LUT.fullmatch(kind):
        return _through(cell, LUT_NS, 1)
    if kind in ("MUXF7", "MUXF8"):
        return _wide_multiplexer(cell)
    if kind == "CARRY4":
        return _carry(cell)
    if kind == "DSP48E1":
        return _multiplier(cell)
    if SHIFT_REGISTER.fullmatch(kind):
        return _clocked(cell, SHIFT_REGISTER_OUT_NS, MEMORY_SETUP_NS)
    if BLOCK_RAM.fullmatch(kind):
        registered = bool(_parameter(cell, "DOA_REG") or _parameter(cell, "DOB_REG"))
        out_ns = BLOCK_RAM_REGISTERED_OUT_NS if registered else BLOCK_RAM_OUT_NS
        return _clocked(cell, out_ns, BLOCK_RAM_SETUP_NS)
    if LUT_RAM.fullmatch(kind):
        return _lut_ram(cell)
    if kind in WIRES_ONLY:
        return _through(cell, 0.0, 0)
    if kind in ("GND", "VCC", "PS7", "BUFIO", "MMCME2_ADV"):
        return CellTiming()
    raise ValueError(f"a cell of type {kind}: its delays are not in scripts/cell_delays.py")
