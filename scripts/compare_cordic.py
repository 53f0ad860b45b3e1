"""Compares our CORDIC lane with others: ``python -m scripts.compare_cordic --zipcpu FOLDER ...``.

Each folder is a clone that the caller makes; nothing of it comes into this tree:

    git clone https://github.com/ZipCPU/cordic zipcpu            (LGPL-3.0)
    git clone https://github.com/kevinpt/vhdl-extras extras      (MIT)
    git clone https://github.com/open-logic/open-logic olo       (PSI HDL library licence)
    git clone https://github.com/enclustra/en_cl_fix en_cl_fix   (MIT; Open Logic needs it)

FloPoCo's operators come from its program, which the caller builds (https://www.flopoco.org, AGPL);
the option can be given for several versions: ``--flopoco VERSION=PROGRAM``. CORDIC II and the lanes
with tables are our own (scripts/cordic_ii_lane.py, scripts/table_lanes.py) and always measured.

Every core gets a cosine of 18 bits, the iterative ones 16 iterations, its vector input tied to a
constant and its sine left open. The same Yosys maps each, scripts/timing.py estimates its longest
path, and Verilator runs the same source over a sweep of the turn. Writes docs/cordic-comparison.md.
Each result is kept in build/cordic-comparison/results, where a later run finds it: a run that was
stopped can be started again.
Needs g++, verilator, git, Yosys and GHDL 5 or newer. Exit code 2 when a tool is missing or a core
cannot be made.
"""

from __future__ import annotations

import argparse
import math
import shutil
import sys
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from scripts import flopoco_lanes
from scripts.cordic_ii_lane import cordic_ii_lane
from scripts.lane_measurement import (
    MAP_LIMIT_S,
    SWEEP_BITS,
    WIDTH,
    Core,
    Measured,
    WrongOutputError,
    measure_once,
    run_tool,
    verilator_version,
)
from scripts.netlist import (
    ROOT,
    TimeLimitError,
    ToolError,
    find_ghdl,
    find_yosys,
    write_netlist,
)
from scripts.table_lanes import table_product_lane, table_rows_lane

WORK = ROOT / "build" / "cordic-comparison"
DOCUMENT = ROOT / "docs" / "cordic-comparison.md"
ITERATIONS = 16
PERIOD_NS = 5.0  # of the clock that a generated core shall reach by the estimate


def _netlist(
    folder: Path, library: str, files: Sequence[Path], entity: str, generics: dict[str, str]
) -> str:
    """Verilog of a VHDL entity of another project, whose library has its own name."""
    ghdl, _ = find_ghdl()
    options = ["--std=08", f"--work={library}", f"--workdir={folder}", "-frelaxed", "-fsynopsys"]
    run_tool([ghdl, "-i", *options, *files], folder)
    run_tool([ghdl, "-m", *options, entity], folder)
    values = [f"-g{name}={value}" for name, value in generics.items()]
    command = [ghdl, "--synth", "--no-formal", *options, "--out=verilog", *values, entity]
    return run_tool(command, folder).decode()


def _ours(folder: Path, _: Sequence[Path]) -> str:
    parts = [
        write_netlist(entity, folder / entity).read_text(encoding="utf-8")
        for entity in ("quadrant_fold", "cordic_rotation")
    ]
    # The rounding and the sign of harmonic_lane, without its multiplier.
    wrapper = f"""
module arctrue_lane (input clock, input [23:0] phase, output reg signed [17:0] cosine);
    wire [21:0] folded;
    wire folded_negative;
    wire [19:0] rotated;
    reg [{ITERATIONS - 2}:0] negative = 0;
    wire [19:0] signed_bits = rotated ^ {{20{{negative[{ITERATIONS - 2}]}}}};
    quadrant_fold fold (
        .clock(clock), .phase(phase), .folded(folded), .negative(folded_negative));
    cordic_rotation rotation (.clock(clock), .folded(folded), .cosine(rotated));
    always @(posedge clock) begin
        negative <= {{negative, folded_negative}};
        cosine <= (signed_bits >> 2) + signed_bits[1];
    end
endmodule
"""
    return "\n".join((*parts, wrapper))


def _zipcpu(folder: Path, clones: Sequence[Path]) -> str:
    generator = folder / "gencordic"
    sources = sorted((clones[0] / "sw").glob("*.cpp"))
    run_tool(["g++", "-O1", "-o", generator, *sources], folder)
    options = ["-t", "p2r", "-f", "cordic.v", "-i", "18", "-o", "18", "-n", "16", "-p", "24"]
    run_tool([generator, *options], folder)
    wrapper = f"""
module zipcpu_lane (input clock, input [23:0] phase, output signed [17:0] cosine);
    wire signed [17:0] sine;
    cordic rotation (.i_clk(clock), .i_reset(1'b0), .i_ce(1'b1), .i_xval(18'd{ZIPCPU_INPUT}),
        .i_yval(18'd0), .i_phase(phase), .o_xval(cosine), .o_yval(sine));
endmodule
"""
    return (folder / "cordic.v").read_text(encoding="utf-8") + wrapper


def _extras(folder: Path, clones: Sequence[Path]) -> str:
    source = clones[0] / "rtl" / "extras"
    files = [source / "pipelining.vhdl", source / "cordic.vhdl"]
    generics = {"SIZE": str(WIDTH), "ITERATIONS": str(ITERATIONS), "FRAC_BITS": "16"}
    core = _netlist(folder, "extras", files, "sincos_pipelined", generics)
    wrapper = f"""
module extras_lane (input clock, input [{WIDTH - 1}:0] phase, output signed [17:0] cosine);
    wire signed [17:0] sine;
    sincos_pipelined rotation (
        .Clock(clock), .Reset(1'b0), .Angle(phase), .Sin(sine), .Cos(cosine));
endmodule
"""
    return core + wrapper


def _open_logic(folder: Path, clones: Sequence[Path]) -> str:
    open_logic, en_cl_fix = clones
    files = [
        *sorted((en_cl_fix / "hdl").glob("*.vhd")),
        *sorted((open_logic / "src" / "base" / "vhdl").glob("olo_base_pkg_*.vhd")),
        open_logic / "src" / "base" / "vhdl" / "olo_base_pl_stage.vhd",
        *sorted((open_logic / "src" / "fix" / "vhdl").glob("olo_fix_*.vhd")),
    ]
    generics = {
        "InMagFmt_g": "(0,1,16)",
        "InAngFmt_g": "(0,0,24)",
        "OutFmt_g": "(1,1,16)",
        "Iterations_g": str(ITERATIONS),
        "Round_g": "NonSymPos_s",
        "Saturate_g": "None_s",
    }
    core = _netlist(folder, "olo", files, "olo_fix_cordic_rot", generics)
    wrapper = """
module open_logic_lane (input clock, input [23:0] phase, output signed [17:0] cosine);
    wire signed [17:0] sine;
    olo_fix_cordic_rot rotation (.Clk(clock), .Rst(1'b0), .In_Valid(1'b1), .In_Mag(17'd65536),
        .In_Ang(phase), .Out_I(cosine), .Out_Q(sine));
endmodule
"""
    return core + wrapper


def _own_lane(verilog: Callable[[], str], folder: Path, _: Sequence[Path]) -> str:
    return verilog()


def _flopoco(
    program: Path,
    operator: flopoco_lanes.Operator,
    frequency_mhz: int,
    folder: Path,
    _: Sequence[Path],
) -> str:
    generated = flopoco_lanes.generate(program, operator, frequency_mhz, folder)
    core = _netlist(folder, "work", [generated.file], generated.entity, {})
    return core + flopoco_lanes.wrapper(generated, WIDTH)


def flopoco_cores(
    program: Path, operator: flopoco_lanes.Operator, frequencies_mhz: Sequence[int]
) -> Iterator[Core]:
    """The same operator for one frequency after the other. Cosine 1 comes out as 1 - 2**lsb."""
    for frequency_mhz in frequencies_mhz:
        yield Core(
            f"FloPoCo {' '.join(operator.call)}: {operator.name}",
            "flopoco_lane",
            "https://www.flopoco.org",
            partial(_flopoco, program, operator, frequency_mhz),
            2.0**-operator.lsb - 1.0,
            1 - operator.lsb,
            f"target={operator.target} frequency={frequency_mhz}; one register after it",
            promised_error=2.0 * 2.0**operator.lsb,
        )


# The largest input; its output is half of input times gain, in which 18 bits are not quite used.
ZIPCPU_INPUT = 2 ** (WIDTH - 1) - 1
ZIPCPU_GAIN = float(np.prod(np.sqrt(1.0 + 4.0 ** -np.arange(1, 17, dtype=float)))) / 2.0

OWN_LANES = ("ours", "cordic_ii", "table_rows", "table_product")
CORES = {
    "ours": Core(
        "ArcTrue quadrant_fold + cordic_rotation",
        "arctrue_lane",
        "rtl/harmonic",
        _ours,
        2.0**16,
        24,
        "cosine only",
    ),
    "cordic_ii": Core(
        "CORDIC II rebuilt, and one nano-rotation more",
        "cordic_ii_lane",
        "doi 10.1109/TCSII.2015.2483422; scripts/cordic_ii_lane.py",
        partial(_own_lane, cordic_ii_lane),
        2.0**16,
        24,
        "cosine only; the publication's angles, our table, widths and last rotation",
    ),
    "table_rows": Core(
        "table in LUTs and a product in rows of adders",
        "table_rows_lane",
        "scripts/table_lanes.py",
        partial(_own_lane, table_rows_lane),
        2.0**16,
        24,
        "cosine only",
    ),
    "table_product": Core(
        "table in LUTs and a product in a DSP",
        "table_product_lane",
        "scripts/table_lanes.py",
        partial(_own_lane, table_product_lane),
        2.0**16,
        24,
        "cosine only",
    ),
    "zipcpu": Core(
        "ZipCPU/cordic, gencordic -t p2r -i 18 -o 18 -n 16 -p 24",
        "zipcpu_lane",
        "https://github.com/ZipCPU/cordic",
        _zipcpu,
        ZIPCPU_INPUT * ZIPCPU_GAIN,
        24,
        "the largest input, which comes out as 1.16 times 2^16",
    ),
    "extras": Core(
        "vhdl-extras sincos_pipelined, SIZE 18, FRAC_BITS 16",
        "extras_lane",
        "https://github.com/kevinpt/vhdl-extras",
        _extras,
        2.0**16,
        18,
        "one width for vector and angle",
    ),
    "olo": Core(
        "Open Logic olo_fix_cordic_rot, s1.16, gain corrected",
        "open_logic_lane",
        "https://github.com/open-logic/open-logic",
        _open_logic,
        2.0**16,
        24,
        "internal formats AUTO",
    ),
}


def measure(
    core: Core, clones: Sequence[Path], folder: Path, limit_s: float = MAP_LIMIT_S
) -> Measured:
    """Make a core, and map and run it, if that was not done before. Raises ToolError."""
    return measure_once(core, _make(core, clones, folder), WORK / "results", limit_s)


def measure_fastest(
    cores: Iterator[Core], folder: Path, limit_s: float = MAP_LIMIT_S
) -> tuple[Core, Measured]:
    """Of the same core made for rising frequencies, the first whose longest path is at most 5 ns.

    If none is so short, that with the shortest path, the first of several. After a core for which
    Yosys needs more than ``limit_s`` seconds, no further one is tried. If none could be measured,
    raises the first NotMadeError, WrongOutputError or TimeLimitError. Raises ToolError where a tool
    fails.
    """
    best: tuple[Core, Measured] | None = None
    refusals: list[ToolError] = []
    for number, core in enumerate(cores):
        try:
            result = measure(core, [], folder / str(number), limit_s)
        except (flopoco_lanes.NotMadeError, TimeLimitError, WrongOutputError) as error:
            print(f"left out: {core.name}, {core.remark}: {error}", flush=True)
            refusals.append(error)
            if isinstance(error, TimeLimitError):
                break
            continue
        print(f"{core.name}, {core.remark}: {result}", flush=True)
        if best is None or result.path_ns < best[1].path_ns:
            best = core, result
        if result.path_ns <= PERIOD_NS:
            break
    if best is None:
        raise refusals[0]
    return best


def _make(core: Core, clones: Sequence[Path], folder: Path) -> Path:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    source = folder / f"{core.top}.v"
    source.write_text(core.make(folder, clones), encoding="utf-8")
    return source


def _version(folder: Path) -> str:
    told = run_tool(["git", "log", "-1", "--format=%h of %ad", "--date=short"], folder)
    return told.decode().strip()


def document(rows: Sequence[tuple[Core, str, Measured]], missing: Sequence[str]) -> str:
    """The page in Markdown."""
    lines = [
        "# CORDIC cores compared",
        "",
        "Made by `scripts/compare_cordic.py`, which says where to get the cores; do not edit.",
        f"{find_ghdl()[1]}, {find_yosys()[1]} (`synth_xilinx -family xc7 -flatten`), Verilator "
        f"{verilator_version()}.",
        "",
        "All cores give the cosine of any angle of the turn, one angle a clock, in 16 to 18 bits;",
        f"those that say no other number have {WIDTH} bits and, where they iterate, {ITERATIONS}",
        "iterations. A vector input is tied to a constant and the sine left open, so that Yosys",
        "removes what only other uses need. The longest path is the estimate of",
        "[timing](timing.md): nothing is placed. The error is the largest |output - cos| of a",
        f"cosine of size 1, over 2^{SWEEP_BITS} angles, evenly spread over the turn with varying",
        "low bits (or all angles, where the core takes fewer bits): first at the angles that the",
        "core takes, then at any angle, rounded to one of them. The last bit of s1.16 is 1.5e-5.",
        "",
        "| core | version | angle bits | LUT | FF | CARRY4 | DSP | RAMB36 | clocks | "
        "longest path, ns | largest error | at any angle |",
        "|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for core, version, result in rows:
        used = result.resources
        lines.append(
            f"| {core.name} | {version} | {core.angle_bits} | {used.lut} | {used.ff} | "
            f"{used.carry4} | {used.dsp} | {used.ramb36:g} | {result.latency} | "
            f"{result.path_ns:.1f} | {result.error:.2e} | {result.error_any_angle:.2e} |"
        )
    lines += [
        "",
        "The cores of others rotate any vector, or give the sine too; ours, and the lanes of this",
        "tree beside it, are made for a cosine of size 1. That is where the area of ours comes",
        "from: it takes the first six iterations from a table, and each register of the remaining",
        "angle is as wide as that angle can still be. What follows for the lane is in",
        "[timing](timing.md#the-lane-beside-published-operators).",
        "",
        f"FloPoCo is asked for {', '.join(map(str, flopoco_lanes.FREQUENCIES_MHZ))} MHz in turn,",
        f"until the longest path is at most {PERIOD_NS:g} ns by our estimate; the row is that",
        "operator, or that with the shortest path. FloPoCo's own estimate of a path is",
        f"shorter than ours. A select of more than {flopoco_lanes.LARGEST_SELECT} words in its "
        "VHDL is rewritten as an",
        "array of the same words, of which GHDL makes a memory; of a select it makes a",
        "multiplexer. An operator with an error of more than two of its last bits is left out:",
        "FloPoCo promises less than one.",
        "",
        "Remarks:",
        "",
    ]
    lines += [
        f"- {core.name}, {version}: {core.remark}; {core.origin}" for core, version, _ in rows
    ]
    lines += [f"- not measured: {text}" for text in missing]
    return "\n".join(lines) + "\n"


def _version_and_program(text: str) -> tuple[str, Path]:
    version, separator, program = text.partition("=")
    if not (version and separator and program):
        raise argparse.ArgumentTypeError(f"expected VERSION=PROGRAM, found {text}")
    return version, Path(program).resolve()


def _seconds_of_minutes(text: str) -> float:
    try:
        minutes = float(text)
    except ValueError:
        minutes = math.nan
    if not (math.isfinite(minutes) and minutes > 0.0):
        raise argparse.ArgumentTypeError(f"expected minutes above 0, found {text}")
    return 60.0 * minutes


def _measured_cores(
    chosen: argparse.Namespace, missing: list[str]
) -> Iterator[tuple[Core, str, Measured]]:
    """Each core that was given, as soon as it is measured; the others' names go to ``missing``."""
    folders: dict[str, list[Path | None]] = {
        **{key: [] for key in OWN_LANES},
        "zipcpu": [chosen.zipcpu],
        "extras": [chosen.extras],
        "olo": [chosen.olo, chosen.en_cl_fix],
    }
    # First, so that a program that is missing is reported before the others are measured.
    asked = []
    for index, (version, program) in enumerate(chosen.flopoco):
        folder = WORK / "flopoco" / str(index)
        folder.mkdir(parents=True, exist_ok=True)
        for number, operator in enumerate(flopoco_lanes.operators(program, folder)):
            asked.append((version, program, operator, folder / str(number)))
    for key, core in CORES.items():
        given = [folder.resolve() for folder in folders[key] if folder]
        if len(given) < len(folders[key]):
            missing.append(f"{core.name}: no folder given; {core.origin}")
            continue
        try:
            result = measure(core, given, WORK / key, chosen.map_limit)
        except TimeLimitError as error:
            missing.append(f"{core.name}: {error}")
            continue
        yield core, " and ".join(_version(folder) for folder in given) or "this tree", result
    if not asked:
        missing.append("FloPoCo: no program given; https://www.flopoco.org")
    for version, program, operator, folder in asked:
        cores = flopoco_cores(program, operator, flopoco_lanes.FREQUENCIES_MHZ)
        try:
            core, result = measure_fastest(cores, folder, chosen.map_limit)
        except (flopoco_lanes.NotMadeError, TimeLimitError, WrongOutputError) as error:
            missing.append(f"FloPoCo {version}, {' '.join(operator.call)}: {error}")
            continue
        yield core, version, result


def main(arguments: list[str] | None = None) -> int:
    """Command line; returns the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    for name in ("zipcpu", "extras", "olo", "en-cl-fix"):
        parser.add_argument(f"--{name}", type=Path, help="folder of the clone")
    parser.add_argument(
        "--flopoco",
        type=_version_and_program,
        action="append",
        default=[],
        metavar="VERSION=PROGRAM",
        help="program of FloPoCo, and its version for the page; may be repeated",
    )
    parser.add_argument(
        "--map-limit",
        type=_seconds_of_minutes,
        default=MAP_LIMIT_S,
        metavar="MINUTES",
        help="longest time for Yosys to map one core, by the clock on the wall: other work counts "
        f"(default: {MAP_LIMIT_S / 60.0:g})",
    )
    parser.add_argument("--output", type=Path, default=DOCUMENT, help="page that is written")
    chosen = parser.parse_args(arguments)
    rows = []
    missing: list[str] = []
    try:
        for core, version, result in _measured_cores(chosen, missing):
            print(f"{core.name}: {result}", flush=True)
            rows.append((core, version, result))
    except ToolError as error:
        print(f"compare_cordic: {error}", file=sys.stderr)
        return 2
    chosen.output.write_text(document(rows, missing), encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
