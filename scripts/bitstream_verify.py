"""Checks that a bitstream computes the same outputs as its VHDL: ``make verify-bitstream``.

The program decodes the finished bitstream back into a netlist, except the PS7, and runs this
netlist in parallel with GHDL's netlist of the VHDL. Both netlists get the same random levels and,
if there is a core, the same accesses (docs/device.md). The program reads the folder that ``make
bitstream FLOW=open`` made. Exit code 1: an output differs, or the test did not reach a part of the
design, such as a DSP, a RAM or a word of coefficients. 2: a file or tool is missing, the pin file
is wrong, a pin is not driven, or a bit or cell cannot be decoded.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from scripts.bitstream import PART, boards, pins_of_all_heads
from scripts.bitstream_constraints import ConstraintError, check_pins
from scripts.bitstream_database import Chip
from scripts.bitstream_decode import Decoded, Decoder, pads_of
from scripts.bitstream_equality import Compared, Port, build, ports_of, run
from scripts.bitstream_features import Bits, Features, bits_of_bitstream
from scripts.bitstream_job import (
    CONSTRAINTS,
    HEADS_TOPS,
    TOPS,
    TWO_HEADS_TOPS,
    Tool,
    all_found,
)
from scripts.bitstream_open import INSTALL, UNPACKED, database_of
from scripts.bitstream_pins import check_pins_driven
from scripts.bitstream_routes import Routes
from scripts.bitstream_stimulus import accesses_of, core_of, questions, shortfalls
from scripts.netlist import ROOT, ToolError

CLOCKS = 200_000
SEED = 1
LOOK_UP_TABLE_OUTPUT: Final = re.compile(r"_[ABCD]o[56]$")
"""Pattern that matches the end of a name: the name of an output of a look-up table as RAM."""
BITREAD = Tool(
    "BITREAD",
    ("bitread",),
    f"{INSTALL}or build Project X-Ray's (github.com/f4pga/prjxray, folder tools); "
    "or name it: BITREAD=/path/to/bitread",
    UNPACKED / "bin",
)


@dataclass(frozen=True)
class Design:
    """Two netlists of a design: GHDL's netlist, and the same netlist mapped by Yosys."""

    top: str
    netlist: Path
    ports: list[Port]

    @staticmethod
    def read(folder: Path, top: str) -> Design:
        """Read a design from ``<top>.v`` and ``<top>.flat.json`` in ``folder``.

        Raises ToolError if a file is missing.
        """
        netlist, mapped = folder / f"{top}.v", folder / f"{top}.flat.json"
        for path in (netlist, mapped):
            if not path.exists():
                raise ToolError(f"{path} is missing: make bitstream FLOW=open makes it")
        module = json.loads(mapped.read_text(encoding="utf-8"))["modules"][top]
        return Design(top, netlist, ports_of(module))

    @property
    def pads(self) -> list[str]:
        """Return the ports of the design that are pads."""
        names = [port.name for port in self.ports if not port.is_processor]
        return list(dict.fromkeys(names))


def decode(
    chip: Chip, bits: Bits, design: Design, pins: Mapping[str, str]
) -> tuple[Decoded, Routes]:
    """Decode the netlist of a configuration; ``pins``: the pin of the package by its port.

    Raises ToolError for a bit without a meaning in the database, or a cell that this program cannot
    decode.
    """
    features = Features(chip, bits)
    strange = features.unexplained()
    if strange:
        raise ToolError(
            f"{len(strange)} bits are unknown to the database, the first: {', '.join(strange[:3])}"
        )
    routes = Routes(features)
    inputs = [line for port in design.ports if port.is_input for line in port.lines()]
    wires = {port.name for port in design.ports if port.is_wire}
    decoder = Decoder(routes, pads_of(chip.family / chip.part, pins), inputs, wires)
    for port in design.ports:
        if port.is_input:
            continue
        for line in port.lines():
            if port.is_processor:
                decoder.add_processor_pin(line)
            else:
                decoder.add_pad(line)
    return decoder.finish(), routes


def faults_of(compared: Compared, *, are_rams_written: bool = True) -> list[str]:
    """Return the faults of a bitstream, or of its test, as sentences.

    ``are_rams_written`` is False if the design writes only constants into its look-up tables as
    RAM: the outputs of these RAMs then need not change.
    """
    faults = []
    if not compared.is_equal:
        shown = "; ".join(compared.differences)
        faults.append(f"{compared.figures['different']} words of outputs differ: {shown}")
    still = [
        name for name in compared.still if are_rams_written or not LOOK_UP_TABLE_OUTPUT.search(name)
    ]
    if still:
        faults.append(f"never moved, so not tested: {', '.join(still)}")
    if not compared.figures["moved_outputs"]:
        faults.append("no output ever moved, so nothing was tested")
    return faults


def run_core(bench: Path, clocks: int, seed: int) -> tuple[Compared, list[str]]:
    """Run the bench with accesses to the core; return the comparison, and a sentence for each part
    that the accesses did not reach.

    Raises ToolError like ``run``.
    """
    core = core_of(run(bench, 1, seed, questions()).answers)
    accesses = accesses_of(core, clocks, seed)
    compared = run(bench, clocks, seed, accesses)
    lacking = shortfalls(core, accesses, compared.answers)
    if not lacking:
        print(
            f"verify-bitstream: {core.lanes} lanes folded by {core.fold}, {core.depth} samples a "
            f"bank; {len(accesses):,} accesses, each of {len(core.coefficients)} words of "
            "coefficients written and read",
            flush=True,
        )
    return compared, lacking


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="bitstream_verify", description=__doc__)
    parser.add_argument("--board", default="pynq_z2", help=f"{', '.join(boards())}, or your board")
    parser.add_argument("--pins", type=Path, help="pin file (constraints/<board>.xdc)")
    parser.add_argument("--heads", type=int, choices=(2, 3, 4), default=2, help="read heads (2)")
    parser.add_argument("--part", default=PART, help=f"chip, package and speed grade ({PART})")
    parser.add_argument(
        "--top", choices=TWO_HEADS_TOPS, default="arctrue_zynq_top", help="top level"
    )
    parser.add_argument(
        "--folder", type=Path, help="folder of the bitstream (build/bitstream/<board>)"
    )
    parser.add_argument(
        "--clocks", type=int, default=CLOCKS, help=f"least number of clocks ({CLOCKS:,})"
    )
    parser.add_argument(
        "--seed", type=int, default=SEED, help=f"seed of levels and accesses ({SEED})"
    )
    return parser


def main(arguments: list[str] | None = None) -> int:
    """Verify the bitstream that the command line names; return the exit code."""
    chosen = _parser().parse_args(arguments)
    folder = (chosen.folder or ROOT / "build" / "bitstream" / chosen.board).resolve()
    bitstream = folder / "arctrue.bit"
    try:
        if not bitstream.exists():
            raise ToolError(f"{bitstream} is missing: make bitstream FLOW=open makes it")
        family, no_family = database_of(chosen.part)
        (reader,) = all_found([BITREAD], [no_family] if no_family else [])
        assert family is not None
        chip = Chip(family, chosen.part)
        board_pins = CONSTRAINTS / f"{chosen.board}.xdc"
        if chosen.heads > 2:
            chosen.top, board_pins = HEADS_TOPS[chosen.top], pins_of_all_heads(board_pins)
        design = Design.read(folder / "netlist", chosen.top)
        pins = check_pins(chosen.pins or board_pins, design.pads)
        print(f"verify-bitstream: decoding {bitstream}", flush=True)
        bits = bits_of_bitstream(bitstream, reader, family / chosen.part / "part.yaml")
        decoded, routes = decode(chip, bits, design, pins)
        driven = check_pins_driven(routes)
        print("verify-bitstream: compiling both netlists (Verilator)", flush=True)
        bench = build(design.netlist, design.top, design.ports, decoded, folder / "verify")
        if TOPS[chosen.top].has_core:
            compared, lacking = run_core(bench, chosen.clocks, chosen.seed)
        else:
            compared, lacking = run(bench, chosen.clocks, chosen.seed), []
    except (ToolError, ConstraintError) as error:
        print(f"verify-bitstream: {error}", file=sys.stderr)
        return 2
    # The encoder source writes its coefficients only once, and the coefficients are constants.
    faults = [*faults_of(compared, are_rams_written=TOPS[chosen.top].has_core), *lacking]
    for fault in faults:
        print(f"verify-bitstream: {fault}", file=sys.stderr)
    figures = compared.figures
    constant = [name for name in compared.still if LOOK_UP_TABLE_OUTPUT.search(name)]
    if constant and not TOPS[chosen.top].has_core:
        print(
            f"verify-bitstream: {len(constant)} outputs of look-up tables as RAM never moved: "
            "the design writes only constants to them"
        )
    pads = [name for name in design.pads if name in compared.quiet]
    if pads:
        print(f"verify-bitstream: pads that never moved: {', '.join(pads)}")
    print(
        f"verify-bitstream: {driven}; "
        f"{figures['clocks']:,} clocks, {figures['outputs']} outputs, of which "
        f"{figures['moved_outputs']} moved, {'all equal' if compared.is_equal else 'differences'}"
    )
    return 1 if faults else 0


if __name__ == "__main__":
    raise SystemExit(main())
