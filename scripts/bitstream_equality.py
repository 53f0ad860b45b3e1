"""Runs a netlist decoded from a bitstream in parallel with its VHDL and compares the outputs.

Verilator compiles both netlists into one program: GHDL's netlist of the VHDL, before any mapping,
and the decoded cells with the models of scripts/bitstream_models. Both netlists get the same random
levels at every pad and every output of the PS7; the bus of the PS7 gets the accesses of a list if
there is one. A pin without a driver in the bitstream gets random levels of its own. All outputs
must be equal before and after every rising edge of the clock.
"""

from __future__ import annotations

import re
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from scripts.bitstream_accesses import Access, Answer, read_answers
from scripts.bitstream_decode import Decoded, bus_bits
from scripts.netlist import ToolError

MODELS: Final = Path(__file__).with_name("bitstream_models")
VERILATOR: Final = (
    *("verilator", "--cc", "--exe", "--build", "-O3", "--x-assign", "0", "--x-initial", "0"),
    *("--no-assert", "-Wno-fatal", "-Wno-lint", "-Wno-style", "-Wno-SYMRSVDWORD", "-Wno-UNOPTFLAT"),
    # Compile without optimisation, because the program runs for seconds only and an optimised
    # compilation would take longer.
    *("-MAKEFLAGS", "OPT_FAST=-O0 OPT_SLOW=-O0 OPT_GLOBAL=-O1", "--output-split", "20000"),
    *("--top-module", "bench", "--prefix", "Vbench", "-o", "bench"),
)
KINDS: Final = (
    (r"FCLKRESETN", "resetn"),
    (r"\w*VALID", "valid"),
    (r"\w*READY", "ready"),
    (r"\w*ADDR", "address"),
    (r"\w*STRB", "strobe"),
    (r"\w*LEN", "length"),
    (r"\w*SIZE", "size"),
    (r"\w*BURST", "burst"),
    (r"\w*LAST", "last"),
    (r"\w*_a", "encoder_a"),
    (r"\w*_b", "encoder_b"),
    (r"\w*_z", "encoder_z"),
    (r"\w*_in", "pulse"),
    (r".*", "data"),
)
"""Kind of stimulus for inputs whose name matches a pattern. The first pattern that matches
applies."""
MASTER: Final = "MAXIGP0"
MASTER_LINES: Final = (
    *("AWVALID", "AWREADY", "AWID", "AWADDR", "AWLEN", "AWSIZE", "AWBURST"),
    *("WVALID", "WREADY", "WDATA", "WSTRB", "WLAST", "BVALID", "BREADY", "BRESP"),
    *("ARVALID", "ARREADY", "ARID", "ARADDR", "ARLEN", "ARSIZE", "ARBURST"),
    *("RVALID", "RREADY", "RDATA", "RRESP", "RLAST"),
)
"""Signals of the PS7's general purpose master 0 (AXI3). A signal that a design lacks has width
0."""


@dataclass(frozen=True)
class Port:
    """Pad of the design, or port of its PS7."""

    name: str
    bits: int
    is_input: bool
    """Whether the design reads the port: from a pad or from an output of the PS7."""
    is_processor: bool
    is_wire: bool = False
    """Whether the port stands for a wire: a pad that both sides may pull low and no side drives
    high. Two ports stand for one such pad: the outside (0 pulls low), and the level of the pad."""

    def lines(self) -> list[str]:
        """Return the names of the port's bits; the PS7's pins in the database have names of this
        form."""
        is_bus = self.is_processor and self.bits > 1
        return [f"{self.name}{bit}" for bit in range(self.bits)] if is_bus else [self.name]


def ports_of(module: dict[str, Any]) -> list[Port]:
    """Return the pads and the PS7's ports of a mapped netlist, inputs first.

    An inout becomes two ports, see ``Port.is_wire``.
    """
    found = [
        Port(name, len(port["bits"]), is_input, False, port["direction"] == "inout")
        for name, port in module["ports"].items()
        for is_input in (True, False)
        if port["direction"] in ("inout", "input" if is_input else "output")
    ]
    for cell in module["cells"].values():
        if cell["type"] == "PS7":
            found += [
                Port(name, len(bits), cell["port_directions"][name] == "output", True)
                for name, bits in cell["connections"].items()
            ]
    return sorted(found, key=lambda port: not port.is_input)


def _placed(ports: Sequence[Port], *, is_input: bool) -> list[tuple[Port, int]]:
    """Return the ports of one direction, each with the number of its first bit in the bus."""
    found, first = [], 0
    for port in ports:
        if port.is_input == is_input:
            found.append((port, first))
            first += port.bits
    return found


def _placed_all(ports: Sequence[Port]) -> list[tuple[Port, int]]:
    """Return inputs and outputs, each with the number of its first bit in the bus of its
    direction."""
    return [place for is_input in (True, False) for place in _placed(ports, is_input=is_input)]


def _reference(top: str, ports: Sequence[Port]) -> str:
    """Return Verilog of a top level that contains the VHDL's netlist; its inputs are the design's
    input pads and the outputs of the PS7; its outputs are the output pads and the inputs of the
    PS7."""
    inputs, outputs = _placed(ports, is_input=True), _placed(ports, is_input=False)
    wide_in = bus_bits(sum(port.bits for port, _ in inputs))
    wide_out = bus_bits(sum(port.bits for port, _ in outputs))
    used = sum(port.bits for port, _ in outputs)
    processor = [port for port in ports if port.is_processor]
    lines = [
        "package ps7_lines;",
        f"logic [{wide_in - 1}:0] from_outside; logic [{wide_out - 1}:0] to_outside;",
        "endpackage",
        "module BUFG (input wire I, output wire O); assign O = I; endmodule",
    ]
    if processor:
        declared = ", ".join(
            f"{'output' if port.is_input else 'input'} wire [{port.bits - 1}:0] {port.name}"
            for port in processor
        )
        lines.append(f"module PS7 ({declared});")
        for port, first in inputs:
            if port.is_processor:
                lines.append(f"assign {port.name} = ps7_lines::from_outside[{first}+:{port.bits}];")
        for port, first in outputs:
            if port.is_processor:
                lines.append(
                    f"always_comb ps7_lines::to_outside[{first}+:{port.bits}] = {port.name};"
                )
        lines.append("endmodule")
    lines += [
        f"module reference (input wire [{wide_in - 1}:0] inputs, "
        f"output wire [{wide_out - 1}:0] outputs);",
        "always_comb ps7_lines::from_outside = inputs;",
    ]
    pads = []
    for bus, placed in (("inputs", inputs), ("outputs", outputs)):
        pads += [
            f".{port.name}({bus}[{first}+:{port.bits}])"
            for port, first in placed
            if not port.is_processor and not port.is_wire
        ]
    for port, first in inputs:
        if port.is_wire:
            lines.append(f"tri1 {port.name}; assign {port.name} = inputs[{first}] ? 1'bz : 1'b0;")
            pads.append(f".{port.name}({port.name})")
    lines += [f"assign outputs[{first}] = {port.name};" for port, first in outputs if port.is_wire]
    lines += [
        f"assign outputs[{first}+:{port.bits}] = ps7_lines::to_outside[{first}+:{port.bits}];"
        for port, first in outputs
        if port.is_processor
    ]
    lines += [f"assign outputs[{wide_out - 1}:{used}] = 0;" if used < wide_out else ""]
    lines += [f"{top} top_level ({', '.join(pads)});", "endmodule", ""]
    return "\n".join(lines)


def without_repeats(netlist: str) -> str:
    """Remove from GHDL's netlist second declarations, and assignments of a signal to itself.

    GHDL declares an output twice, as a port and as a wire. Verilator accepts only one declaration;
    of two assignments it takes the first.
    """
    kept = []
    ports: set[str] = set()
    for line in netlist.splitlines():
        if line.startswith("module "):
            ports = set()
        found = re.fullmatch(r"\s*(?:output|input)\s+(?:\[[^]]*\]\s*)?(\S+?)[,);]*", line)
        if found:
            ports.add(found[1])
        again = re.fullmatch(r"\s*wire\s+(?:\[[^]]*\]\s*)?(\S+);", line)
        itself = re.fullmatch(r"\s*assign (\S+) = (\S+);.*", line)
        is_itself = bool(itself and itself[1] == itself[2])
        if not is_itself and not (again and again[1] in ports):
            kept.append(line)
    return "\n".join([*kept, ""])


def direct_tristates(netlist: str) -> str:
    """Connect an inout directly to its driver or reader, because GHDL puts two wires between an
    inout and its driver or reader.

    Verilator supports 1'bz only in an assignment to the port itself.
    """
    ways = dict(re.findall(r"assign (\w+) = (\w+ \? 1'b0 : 1'bz);", netlist))
    inner = dict(re.findall(r"assign (\w+) = (\w+); // \(inout - port\)", netlist))

    def direct(found: re.Match[str]) -> str:
        way = ways.get(inner.get(found["wire"], ""))
        return f"assign {found['port']} = {way};" if way else found[0]

    return re.sub(r"assign (?P<port>\w+) = (?P<wire>\w+);", direct, netlist)


def _bench(decoded: Decoded, inputs: int, outputs: int) -> str:
    active = sum(count for _, _, count in decoded.activity)
    buses = (
        ("input", "inputs", inputs),
        ("input", "open_lines", len(decoded.open_pins)),
        ("output", "expected", outputs),
        ("output", "found", outputs),
        ("output", "activity", active),
    )
    ports = ", ".join(f"{way} wire [{bus_bits(bits) - 1}:0] {name}" for way, name, bits in buses)
    return "\n".join(
        (
            f"module bench ({ports});",
            "reference reference (.inputs(inputs), .outputs(expected));",
            "decoded decoded (.inputs(inputs), .open_lines(open_lines), .outputs(found),",
            "  .activity(activity));",
            "endmodule",
            "",
        )
    )


def _kind(port: Port, first: int, clock: int) -> str:
    if first <= clock < first + port.bits:
        return "clock"
    return next(kind for pattern, kind in KINDS if re.fullmatch(pattern, port.name))


def _lines_header(ports: Sequence[Port], decoded: Decoded) -> str:
    """Return C++ constants that describe the bits of the buses."""
    inputs = _placed(ports, is_input=True)
    heads: dict[str, int] = {}
    rows = []
    for port, first in inputs:
        kind = _kind(port, first, decoded.clock)
        head = port.name.rpartition("_")[0] if kind.startswith("encoder_") else ""
        place = heads.setdefault(head, len(heads)) if head else 0
        is_master = str(port.name.startswith(MASTER)).lower()
        rows.append(f"    {{{first}, {port.bits}, Kind::{kind}, {place}, {is_master}}},")
    blocks = [f'    {{"{name}", {first}, {bits}}},' for name, first, bits in decoded.activity]
    names = ", ".join(f'"{name}"' for name in decoded.outputs)
    places = {port.name: (first, port.bits) for port, first in _placed_all(ports)}
    master = [
        f"    {{{first}, {bits}}},  // {line}"
        for line in MASTER_LINES
        for first, bits in [places.get(f"{MASTER}{line}", (0, 0))]
    ]
    pulses = sum(_kind(port, first, decoded.clock) == "pulse" for port, first in inputs)
    active = sum(count for _, _, count in decoded.activity)
    kinds = ", ".join(dict.fromkeys(["clock", *(kind for _, kind in KINDS)]))

    def words(count: int) -> int:
        return -(-bus_bits(count) // 32)

    return "\n".join(
        (
            "#pragma once",
            "#include <vector>",
            f"enum class Kind {{ {kinds} }};",
            "struct Line { int first; int bits; Kind kind; unsigned encoder; bool is_master; };",
            "struct Lines { int first; int bits; };",
            f"struct MasterLines {{ Lines {', '.join(MASTER_LINES).lower()}; }};",
            f"constexpr MasterLines AXI = {{\n{chr(10).join(master)}\n}};",
            "struct Block { const char* name; int first; int bits; };",
            f"constexpr Line LINES[] = {{\n{chr(10).join(rows)}\n}};",
            # ENCODERS is at least 1 and OUTPUTS has at least 96 entries, because C++ has no empty
            # arrays.
            f"constexpr int BLOCK_COUNT = {len(blocks)};",
            f"constexpr int ENCODERS = {max(1, len(heads))};",
            f"constexpr int PULSES = {pulses};",
            f"constexpr int CLOCK_LINE = {decoded.clock};",
            f"constexpr int OUTPUT_COUNT = {len(decoded.outputs)};",
            f"constexpr int OUTPUT_WORDS = {words(len(decoded.outputs))};",
            f"constexpr int OPEN_WORDS = {words(len(decoded.open_pins))};",
            f"constexpr int ACTIVITY_WORDS = {words(active)};",
            f"constexpr const char* OUTPUTS[OUTPUT_WORDS * 32] = {{{names}}};",
            f"const std::vector<Block> BLOCKS = {{\n{chr(10).join(blocks)}\n}};",
            "",
        )
    )


@dataclass(frozen=True)
class Compared:
    """Result of a run: a sentence for each of the first differences, and counts by name."""

    differences: list[str]
    still: list[str]
    """Names of the DSPs, halves of block RAMs and outputs of look-up tables as RAM that never
    changed."""
    figures: Mapping[str, int]
    quiet: list[str] = field(default_factory=list)
    """Names of outputs that never changed."""
    answers: Sequence[Answer] = ()

    @property
    def is_equal(self) -> bool:
        """Tell whether all outputs were equal in all clocks."""
        return self.figures["different"] == 0


def build(netlist: Path, top: str, ports: Sequence[Port], decoded: Decoded, folder: Path) -> Path:
    """Build the program that runs ``netlist`` (GHDL's Verilog of ``top``) and the decoded netlist.

    Raises ToolError if Verilator or the compiler fails.
    """
    folder.mkdir(parents=True, exist_ok=True)
    inputs, outputs = _placed(ports, is_input=True), _placed(ports, is_input=False)
    texts = {
        "design.v": direct_tristates(without_repeats(netlist.read_text(encoding="utf-8"))),
        "decoded.v": decoded.verilog,
        "reference.sv": _reference(top, ports),
        "bench.sv": _bench(
            decoded,
            sum(port.bits for port, _ in inputs),
            sum(port.bits for port, _ in outputs),
        ),
        "lines.h": _lines_header(ports, decoded),
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    sources = [folder / name for name in ("reference.sv", "bench.sv", "decoded.v", "design.v")]
    sources += [*sorted(MODELS.glob("*.v")), MODELS / "bench.cpp"]
    made = folder / "verilated"
    headers = f"-std=c++17 -I{folder.resolve()} -I{MODELS.resolve()}"
    command = [*VERILATOR, "-CFLAGS", headers, "--Mdir", str(made)]
    log = folder / "verilator.log"
    with log.open("w", encoding="utf-8") as file:
        try:
            done = subprocess.run(
                [*command, *(str(source) for source in sources)],
                stdout=file,
                stderr=subprocess.STDOUT,
                check=False,
            )
        except OSError as error:
            raise ToolError(f"verilator cannot be started: {error}; make setup") from error
    if done.returncode:
        tail = "\n".join(log.read_text(encoding="utf-8", errors="replace").splitlines()[-15:])
        raise ToolError(f"verilator failed. The end of {log}:\n{tail}")
    return made / "bench"


def run(bench: Path, clocks: int, seed: int, accesses: Sequence[Access] = ()) -> Compared:
    """Run the bench for ``clocks`` clocks or more, until the VHDL has answered all ``accesses``.

    Without accesses, all signals from the processor get random levels. Raises ToolError if the
    bench ends without a result.
    """
    command = [str(bench), str(clocks), str(seed)]
    answered = bench.with_name("answers.txt")
    if accesses:
        listed = bench.with_name("accesses.txt")
        listed.write_text("".join(f"{access.line()}\n" for access in accesses), encoding="ascii")
        command += [str(listed), str(answered)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    lines = done.stdout.splitlines()
    if not lines or not lines[-1].startswith("clocks="):
        raise ToolError(f"{bench} ended early: {done.stderr.strip()[-300:]}")
    figures = {name: int(value) for name, value in re.findall(r"(\w+)=(\d+)", lines[-1])}
    return Compared(
        differences=[line for line in lines if line.startswith("clock ")],
        still=[line.removeprefix("still: ") for line in lines if line.startswith("still: ")],
        figures=figures,
        quiet=[line.removeprefix("quiet: ") for line in lines if line.startswith("quiet: ")],
        answers=read_answers(answered) if accesses else (),
    )
