"""Compares look-up tables as RAM, decoded from features, with the chip's primitives (UG953)."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from scripts.bitstream_database import Chip
from scripts.bitstream_features import Features
from scripts.bitstream_lut_rams import ram_pins
from scripts.bitstream_pins import Driven, check_pins_driven, has_no_source
from scripts.bitstream_routes import Routes
from scripts.bitstream_slices import Slice, Text
from scripts.netlist import ToolError

LETTERS = "ABCD"
CLOCKS = 4000
Levels = Mapping[str, int]


def address(levels: Levels, table: str, bits: int) -> int:
    return sum(levels[f"{table}{place + 1}"] << place for place in range(bits))


@dataclass
class Memory:
    """Configured slice, and the behaviour of the primitive that it implements.

    ``tied`` states the pins that have a constant level or the level of another pin; ``read`` and
    ``write`` describe the primitive in terms of the slice's pins.
    """

    features: set[str]
    outputs: list[str]
    read: Callable[[Levels], list[int]]
    write: Callable[[Levels], None]
    tied: dict[str, str] = field(default_factory=dict)

    @property
    def free(self) -> list[str]:
        """Return the pins that can change independently of others."""
        pins = {f"{letter}{place}" for letter in LETTERS for place in range(1, 7)}
        pins |= {"AI", "BI", "CI", "DI", "AX", "BX", "CX", "DX", "CE", "WE"}
        return sorted(pins - self.tied.keys())


def init_features(letter: str, value: int) -> set[str]:
    return {f"{letter}LUT.INIT[{bit:02}]" for bit in range(64) if value >> bit & 1}


def random_init(rng: np.random.Generator) -> int:
    return int.from_bytes(rng.bytes(8), "little")


def ram32m(rng: np.random.Generator) -> Memory:
    """Return a RAM32M: 32 words of four times two bits; each pair of bits has its own data inputs
    and read address."""
    memory = {letter: [int(bit) for bit in rng.integers(0, 2, 64)] for letter in LETTERS}
    features = {f"{letter}LUT.{mode}" for letter in LETTERS for mode in ("RAM", "SMALL")}
    features |= {f"{letter}LUT.DI1MUX.{letter}I" for letter in "ABC"} | {"WEMUX.CE"}
    features |= {f"{letter}OUTMUX.O5" for letter in LETTERS}
    for letter, bits in memory.items():
        halves = [*bits[0::2], *bits[1::2]]
        features |= init_features(letter, sum(bit << place for place, bit in enumerate(halves)))

    def read(levels: Levels) -> list[int]:
        places = [(letter, 2 * address(levels, letter, 5)) for letter in LETTERS]
        return [memory[letter][place + bit] for letter, place in places for bit in (0, 1)]

    def write(levels: Levels) -> None:
        if levels["CE"]:
            place = 2 * address(levels, "D", 5)
            for letter in LETTERS:
                memory[letter][place : place + 2] = levels[f"{letter}I"], levels[f"{letter}X"]

    outputs = [f"{letter}{kind}" for letter in LETTERS for kind in ("MUX", "")]
    tied = {f"{letter}6": "1'b1" for letter in LETTERS}
    return Memory(features, outputs, read, write, tied)


def ram64x1d_twice(rng: np.random.Generator) -> Memory:
    """Return two RAM64X1D with one write address: D and C store the data at DI, B and A store the
    data at BI."""
    inits = random_init(rng), random_init(rng)
    memory = [[init >> place & 1 for place in range(64)] for init in inits]
    features = {f"{letter}LUT.RAM" for letter in LETTERS} | {"BLUT.DI1MUX.BI"}
    for letter, init in zip("DCBA", (inits[0], inits[0], inits[1], inits[1]), strict=True):
        features |= init_features(letter, init)

    def read(levels: Levels) -> list[int]:
        return [memory[letter in "AB"][address(levels, letter, 6)] for letter in LETTERS]

    def write(levels: Levels) -> None:
        if levels["WE"]:
            for data, pin in zip(memory, ("DI", "BI"), strict=True):
                data[address(levels, "D", 6)] = levels[pin]

    return Memory(features, list(LETTERS), read, write)


def same_address(tables: str) -> dict[str, str]:
    """Return the input pins of ``tables`` with the pins of D to which they are connected."""
    return {f"{table}{place}": f"D{place}" for table in tables for place in range(1, 7)}


def ram128x1d(rng: np.random.Generator) -> Memory:
    """Return a RAM128X1D: inputs D1 to D6 and CX are the write address and one read address, B1 to
    B6 and AX are the other read address."""
    init = random_init(rng) | random_init(rng) << 64
    memory = [init >> place & 1 for place in range(128)]
    features = {f"{letter}LUT.RAM" for letter in LETTERS} | {"WA7USED"}
    features |= {"AOUTMUX.F7", "COUTMUX.F7"}
    for letter, first in {"A": 64, "B": 0, "C": 64, "D": 0}.items():
        features |= init_features(letter, init >> first & (1 << 64) - 1)

    def read(levels: Levels) -> list[int]:
        return [
            memory[address(levels, table, 6) + 64 * levels[pin]]
            for table, pin in (("B", "AX"), ("D", "CX"))
        ]

    def write(levels: Levels) -> None:
        if levels["WE"]:
            memory[address(levels, "D", 6) + 64 * levels["CX"]] = levels["DI"]

    tied = same_address("C") | {f"A{place}": f"B{place}" for place in range(1, 7)}
    return Memory(features, ["AMUX", "CMUX"], read, write, tied)


def ram256x1s(rng: np.random.Generator) -> Memory:
    """Return a RAM256X1S, whose address for reading and writing is at D's inputs, CX (and AX), and
    BX."""
    inits = [random_init(rng) for _ in LETTERS]
    init = sum(value << 64 * place for place, value in enumerate(inits))
    memory = [init >> place & 1 for place in range(256)]
    features = {f"{letter}LUT.RAM" for letter in LETTERS} | {"WA7USED", "WA8USED", "BOUTMUX.F8"}
    for letter, value in zip("DCBA", inits, strict=True):
        features |= init_features(letter, value)

    def place(levels: Levels) -> int:
        return address(levels, "D", 6) + 64 * levels["CX"] + 128 * levels["BX"]

    def read(levels: Levels) -> list[int]:
        return [memory[place(levels)]]

    def write(levels: Levels) -> None:
        if levels["WE"]:
            memory[place(levels)] = levels["DI"]

    return Memory(features, ["BMUX"], read, write, same_address("ABC") | {"AX": "CX"})


BENCH = """
module bench;
  reg [{last}:0] pins;
  reg [{last}:0] stimuli [0:{clocks} - 1];
  wire [{last_output}:0] outputs;
  integer row;
  slices slices (pins, outputs);
  initial begin
    $readmemh("stimuli.hex", stimuli);
    for (row = 0; row < {clocks}; row = row + 1) begin
      pins = stimuli[row]; pins[0] = 0;
      #1 $display("%b", outputs);
      pins[0] = 1;
      #1;
    end
    $finish;
  end
endmodule
"""


def simulated(memories: list[Memory], rows: np.ndarray, folder: Path) -> list[str]:
    """Return the outputs before every clock edge, from Verilator; each of ``rows`` has a level for
    every free pin."""
    text = Text()
    place = 1
    outputs: list[str] = []
    for number, memory in enumerate(memories):
        nets = {"CLK": "clock"}
        for pin in memory.free:
            nets[pin] = f"pins[{place}]"
            place += 1
        for pin, level in memory.tied.items():
            nets[pin] = nets.get(level, level)
        made = Slice(f"S{number}", frozenset(memory.features), nets.__getitem__, text)
        outputs += [made.output(pin) for pin in memory.outputs]
    assert set(text.clocked) == {"posedge clock"}
    lines = [
        f"module slices (input wire [{place - 1}:0] pins, output wire [{len(outputs) - 1}:0] out);",
        "wire clock = pins[0];",
        *text.declarations,
        *text.assignments,
        "always @(posedge clock) begin",
        *text.clocked["posedge clock"],
        "end",
        f"assign out = {{{', '.join(outputs)}}};",
        "endmodule",
        BENCH.format(last=place - 1, clocks=len(rows), last_output=len(outputs) - 1),
    ]
    (folder / "bench.sv").write_text("\n".join(lines), encoding="ascii")
    words = [sum(int(bit) << at + 1 for at, bit in enumerate(row)) for row in rows]
    (folder / "stimuli.hex").write_text("".join(f"{word:x}\n" for word in words), encoding="ascii")
    command = ["verilator", "--binary", "-Wno-fatal", "-Wno-lint", "--top-module", "bench"]
    command += ["-MAKEFLAGS", "OPT_FAST=-O0 OPT_SLOW=-O0 OPT_GLOBAL=-O0", "bench.sv"]
    for step in (command, ["obj_dir/Vbench"]):
        done = subprocess.run(
            step, cwd=folder, capture_output=True, text=True, timeout=300, check=False
        )
        assert done.returncode == 0, done.stderr
    return [line for line in done.stdout.splitlines() if line[:1] in ("0", "1")]


@pytest.mark.large
@pytest.mark.skipif(not shutil.which("verilator"), reason="needs verilator")
def test_rams_of_look_up_tables_do_what_the_primitives_do(tmp_path: Path) -> None:
    """The decoded RAM32M, RAM64X1D, RAM128X1D and RAM256X1S behave like the primitives, with random
    initial contents and random levels at every pin."""
    rng = np.random.default_rng(1)
    memories = [make(rng) for make in (ram32m, ram64x1d_twice, ram128x1d, ram256x1s)]
    rows = rng.integers(0, 2, (CLOCKS, sum(len(memory.free) for memory in memories)))
    found = simulated(memories, rows, tmp_path)
    expected = []
    for row in rows:
        read: list[int] = []
        start = 0
        for memory in memories:
            free = memory.free
            levels = dict(zip(free, map(int, row[start : start + len(free)]), strict=True))
            levels |= {pin: levels.get(level, 1) for pin, level in memory.tied.items()}
            read += memory.read(levels)
            memory.write(levels)
            start += len(free)
        expected.append("".join(map(str, read)))
    assert found == expected


SMALL = {"DLUT.RAM", "ALUT.RAM", "ALUT.SMALL"}


@pytest.mark.parametrize(
    ("features", "pin", "message"),
    [
        ({"ALUT.RAM"}, "A", "DLUT, whose inputs are its write address, is not"),
        ({"DLUT.RAM", "BLUT.SRL"}, "D", "BLUT is a shift register; a slice with both"),
        (SMALL | {"WA7USED"}, "A", "a RAM of 32 words with WA7USED"),
        ({"DLUT.RAM", "WA8USED"}, "D", "WA8USED without WA7USED"),
        (SMALL, "A", "A6 is not always 1"),
        ({"DLUT.RAM", "DOUTMUX.O5"}, "DMUX", "O5 of DLUT, a RAM of 64 words, is not decoded"),
        ({"DLUT.RAM", "DOUTMUX.MC31"}, "DMUX", "MC31 of DLUT is used, but DLUT is not a shift"),
    ],
)
def test_a_ram_that_is_not_decoded_is_refused(features: set[str], pin: str, message: str) -> None:
    with pytest.raises(ToolError, match=message):
        Slice("S", frozenset(features), str, Text()).output(pin)


def test_a_ram_is_written_at_the_edge_that_the_slice_has() -> None:
    text = Text()
    Slice("S", frozenset({"DLUT.RAM", "CLKINV"}), str, text).output("D")
    assert text.clocked == {
        "negedge CLK": ["if (WE) S_Dram[{D6, D5, D4, D3, D2, D1}] <= DI;"],
    }


def test_the_pins_that_a_ram_depends_on_are_reported() -> None:
    """The program lists the pins on which a RAM depends; data input 1 of A comes from DI through B
    unless a feature selects another source."""
    numbered = {f"{letter}{place}" for letter in "AD" for place in range(1, 7)}
    assert set(ram_pins(frozenset(SMALL | {"WEMUX.CE"}))) == numbered | {"CLK", "CE", "DI", "AX"}
    deep = frozenset({"DLUT.RAM", "WA7USED", "WA8USED"})
    assert set(ram_pins(deep)) >= {"CX", "BX", "WE"}
    assert ram_pins(frozenset({"DLUT.SRL"})) == []


def slice_with_ram(folder: Path, undriven: str) -> Routes:
    """Return the routes of a tile with one slice; table D of the slice is a RAM, and all pins
    except ``undriven`` are 1 by default."""
    family = folder / "zynq7"
    (family / "xc7z020").mkdir(parents=True)
    block = {"CLB_IO_CLK": {"baseaddr": "0x10", "frames": 1, "offset": 0, "words": 1}}
    grid = {"M": {"type": "M", "grid_x": 0, "grid_y": 0, "bits": block}}
    pins = [*(f"D{place}" for place in range(1, 7)), "DI", "WE", "CLK", "AX"]
    sites = [
        {
            "name": "X0Y0",
            "type": "SLICEM",
            "prefix": "SLICE",
            "site_pins": {pin: {"wire": pin} for pin in pins},
        },
        {
            "name": "X1Y0",
            "type": "TIEOFF",
            "prefix": "TIEOFF",
            "site_pins": {"HARD1": {"wire": "HIGH"}},
        },
    ]
    pips = {pin: {"dst_wire": pin, "src_wire": "HIGH", "is_directional": "1"} for pin in pins}
    defaults = "".join(f"M.{pin}.HIGH default\n" for pin in pins if pin != undriven)
    inputs = {pin: {"direction": "IN"} for pin in pins}
    for name, content in (
        ("xc7z020/tilegrid.json", json.dumps(grid)),
        ("xc7z020/tileconn.json", "[]"),
        ("tile_type_M.json", json.dumps({"sites": sites, "pips": pips})),
        ("site_type_SLICEM.json", json.dumps({"site_pins": inputs})),
        ("site_type_TIEOFF.json", json.dumps({"site_pins": {"HARD1": {"direction": "OUT"}}})),
        ("segbits_m.db", "M.SLICEM_X0.DLUT.RAM 00_01\n"),
        ("ppips_m.db", defaults),
    ):
        (family / name).write_text(content, encoding="ascii")
    return Routes(Features(Chip(family, "xc7z020clg400-1"), {0x10: frozenset({1})}))


@pytest.mark.parametrize("pin", ["D3", "DI", "WE", "CLK"])
def test_a_pin_of_a_ram_that_nothing_drives_is_refused(tmp_path: Path, pin: str) -> None:
    message = f"1 pins .*\n  - M SLICEM, look-up tables as RAM: {pin} has no route"
    with pytest.raises(ToolError, match=message):
        check_pins_driven(slice_with_ram(tmp_path, pin))


def test_a_ram_with_all_its_pins_driven_is_counted(tmp_path: Path) -> None:
    """A slice whose RAM has all its pins driven counts as driven; a RAM of 64 words does not use
    AX."""
    driven = check_pins_driven(slice_with_ram(tmp_path, "AX"))
    assert driven == Driven(blocks=0, slices=1)
    assert "and 1 slices with look-up tables as RAM, every pin driven" in str(driven)


@pytest.mark.parametrize(
    ("tile", "name", "pin", "none"),
    [
        ("DSP_L_X14Y0", "DSP48.DSP_0", "PCIN47", True),
        ("DSP_R_X9Y0", "DSP48.DSP_0", "MULTSIGNIN", True),
        ("DSP_L_X14Y0", "DSP48.DSP_1", "PCIN47", False),
        ("DSP_L_X14Y50", "DSP48.DSP_0", "PCIN47", False),
        ("DSP_L_X14Y0", "DSP48.DSP_0", "A3", False),
        ("BRAM_L_X6Y0", "RAMB18_Y0", "DIADI0", False),
    ],
)
def test_only_the_lowest_dsp_of_a_column_has_no_cascade(
    tile: str, name: str, pin: str, none: bool
) -> None:
    """Only the cascade inputs of the lowest DSP of a column have no source; the DSP below drives
    those of all others (UG479)."""
    assert has_no_source(tile, name, pin) is none
