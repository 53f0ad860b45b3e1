"""Measures the core's lanes and a lane with a DSP with the same tools: ``make compare-lanes``.

Yosys maps the Verilog of a lane, scripts/timing_paths.py estimates the lane's longest path, and
Verilator simulates the lane over a sweep of the turn. The script prints the table of results and
writes it between the marks in docs/cordic-comparison.md; the page also lists published operators,
which were measured once. The script needs Verilator, Yosys and GHDL 5 or newer, and takes a few
minutes. Exit code 2: a tool is missing or fails.

The lanes of the core are quadrant_fold with cordic_rotation and quadrant_fold with table_rotation.
The third lane is not part of the core: it has the table of table_rotation, but a DSP computes its
product instead of rows of adders.
"""

from __future__ import annotations

import argparse
import math
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from scripts.marked_section import MarkedSection
from scripts.netlist import ROOT, ToolError, find_ghdl, find_yosys, synthesise, write_netlist
from scripts.resources import Design, Resources
from scripts.timing_paths import Netlist, longest_paths

Integers = NDArray[np.int64]

WORK: Final = ROOT / "build" / "cordic-comparison"
PAGE: Final = ROOT / "docs" / "cordic-comparison.md"
BEGIN = "<!-- written by make compare-lanes -->\n"
AMPLITUDE: Final = 2.0**16
"""Value of a cosine of 1 in units of the last bit of s1.16."""
WIDTH: Final = 18
LARGEST_ERROR: Final = 0.01
"""Largest error with which an output still counts as a cosine."""
SWEEP_BITS: Final = 20
SETTLING: Final = 64
"""Number of clocks that the simulation runs before the sweep."""
LATENCIES: Final = range(48)
TIMEOUT_S: Final = 1800
PHASE_FRACTION: Final = 24
FOLDED_BITS: Final = PHASE_FRACTION - 2
ADDRESS_BITS: Final = 7
OFFSET_BITS: Final = FOLDED_BITS - ADDRESS_BITS
VALUE_FRACTION: Final = 20
SLOPE_FRACTION: Final = 8
HALF_OF_LAST_BIT: Final = 2.0**-17
"""Half of the last bit of a cosine s1.16."""

MAIN: Final = """
#include <cstdint>
#include <cstdio>
#include "V{top}.h"
int main() {{
    V{top} top;
    for (uint32_t clock = 0; clock < {clocks}u; clock++) {{
        // Evenly over the turn; the low bits go through all values too.
        uint32_t k = clock - {settling}u;
        top.phase = ((k << {shift}) | (k * 2654435761u >> {low})) & 0x{mask:x}u;
        top.clock = 0;
        top.eval();
        top.clock = 1;
        top.eval();
        int32_t cosine = top.cosine;
        fwrite(&cosine, sizeof cosine, 1, stdout);
    }}
}}
"""


class WrongOutputError(ToolError):
    """Raised if the output of a lane is not the cosine of any of the preceding phases."""


@dataclass(frozen=True)
class Measured:
    """Resources of a lane, its longest path by the estimate, its latency and its largest errors.

    ``error`` is the largest error at phases that the lane can represent. ``error_any_angle`` is the
    largest error at any angle; the lane gets the nearest of these phases.
    """

    resources: Resources
    path_ns: float
    latency: int
    error: float
    error_any_angle: float


def _lane_of(rotation: str, *inputs: str) -> str:
    """Return Verilog of a lane of quadrant_fold and ``rotation``, with the rounding and the sign
    that harmonic_lane adds.

    ``inputs``: outputs of quadrant_fold that the rotation takes.
    """
    connected = ", ".join(f".{name}({name})" for name in inputs)
    parts = [
        write_netlist(entity, WORK / entity).read_text(encoding="utf-8")
        for entity in ("quadrant_fold", rotation)
    ]
    wrapper = f"""
module {rotation.partition("_")[0]}_lane (
    input clock, input [23:0] phase, output reg signed [17:0] cosine
);
    wire [21:0] folded, place;
    wire mirrored, folded_negative;
    wire [19:0] rotated;
    reg [14:0] negative = 0;
    wire [19:0] signed_bits = rotated ^ {{20{{negative[14]}}}};
    quadrant_fold fold (
        .clock(clock), .phase(phase), .folded(folded), .place(place), .mirrored(mirrored),
        .negative(folded_negative));
    {rotation} rotation (.clock(clock), {connected}, .cosine(rotated));
    always @(posedge clock) begin
        negative <= {{negative, folded_negative}};
        cosine <= (signed_bits >> 2) + signed_bits[1];
    end
endmodule
"""
    return "\n".join((*parts, wrapper))


def cordic_lane() -> str:
    """Return Verilog of a lane with ROTATION = cordic."""
    return _lane_of("cordic_rotation", "place", "mirrored")


def table_lane() -> str:
    """Return Verilog of a lane with ROTATION = table."""
    return _lane_of("table_rotation", "folded")


def verilog_table(
    name: str, inputs: int, outputs: int, values: Sequence[int] | NDArray[np.int64]
) -> str:
    """Return a Verilog function that returns the element of ``values`` at an index of ``inputs``
    bits.

    The function's result has ``outputs`` bits, two's complement; it is 0 for an index beyond the
    end of ``values``.
    """
    mask = (1 << outputs) - 1
    cases = "\n".join(
        f"            {inputs}'d{index}: {name} = {outputs}'h{int(value) & mask:x};"
        for index, value in enumerate(values)
    )
    return f"""
    function [{outputs - 1}:0] {name};
        input [{inputs - 1}:0] index;
        case (index)
{cases}
            default: {name} = {outputs}'h0;
        endcase
    endfunction
"""


def table_middles() -> NDArray[np.float64]:
    """Return the angle in the middle of each interval of the table, in radians; the table covers a
    quadrant."""
    index = np.arange(1 << ADDRESS_BITS)
    middles: NDArray[np.float64] = (index + 0.5) * (math.pi / 2) / (1 << ADDRESS_BITS)
    return middles


def table_slopes() -> Integers:
    """Return the slopes 2 pi sin a of the table, in u3.8 per turn."""
    slopes: Integers = np.round(
        2.0 * math.pi * np.sin(table_middles()) * 2.0**SLOPE_FRACTION
    ).astype(np.int64)
    return slopes


def table_values() -> Integers:
    """Return, in s1.20, the value that the tangent to the cosine has at the start of each interval.

    At a distance of z radians from the middle, the tangent exceeds the cosine by up to z**2/2. Half
    of the largest such error is subtracted, which balances the errors; half of the last bit of the
    result is added, which rounds the product.
    """
    middles = table_middles()
    reach_turn = 2.0 ** (OFFSET_BITS - 1 - PHASE_FRACTION)
    scale = 1.0 - (2.0 * math.pi * reach_turn) ** 2 / 4.0
    half_unit_turn = 2.0 ** (-1 - PHASE_FRACTION)
    slope = table_slopes() / 2.0**SLOPE_FRACTION
    begins = scale * np.cos(middles) + slope * (reach_turn - half_unit_turn)
    values: Integers = np.round((begins + HALF_OF_LAST_BIT) * 2.0**VALUE_FRACTION).astype(np.int64)
    return values


def table_product_lane() -> str:
    """Return Verilog of a lane with a table in LUTs and one product in a DSP; its latency is 5
    clocks."""
    slope_bits = SLOPE_FRACTION + 4
    product_fraction = SLOPE_FRACTION + PHASE_FRACTION
    values = table_values()
    return f"""
module table_product_lane (input clock, input [23:0] phase, output reg signed [17:0] cosine = 0);
{verilog_table("value_of", ADDRESS_BITS, VALUE_FRACTION + 2, values)}
{verilog_table("slope_of", ADDRESS_BITS, slope_bits, -table_slopes())}
    reg [4:1] negative = 0;
    reg [{FOLDED_BITS - 1}:0] folded = 0;
    reg signed [{VALUE_FRACTION + 1}:0] value2 = 0, value3 = 0;
    reg signed [{slope_bits - 1}:0] slope = 0;
    reg signed [{OFFSET_BITS}:0] offset = 0;
    reg signed [{slope_bits + OFFSET_BITS}:0] product = 0;
    reg signed [{product_fraction + 1}:0] sum = 0;
    wire signed [17:0] rounded = sum[{product_fraction + 1}:{product_fraction - 16}];

    always @(posedge clock) begin
        negative <= {{negative[3:1], phase[23] ^ phase[22]}};
        folded <= phase[{FOLDED_BITS - 1}:0] ^ {{{FOLDED_BITS}{{phase[22]}}}};
        value2 <= value_of(folded[{FOLDED_BITS - 1}:{OFFSET_BITS}]);
        slope <= slope_of(folded[{FOLDED_BITS - 1}:{OFFSET_BITS}]);
        offset <= {{1'b0, folded[{OFFSET_BITS - 1}:0]}};
        product <= slope * offset;
        value3 <= value2;
        sum <= (value3 <<< {product_fraction - VALUE_FRACTION}) + product;
        cosine <= (rounded ^ {{18{{negative[4]}}}}) + {{17'd0, negative[4]}};
    end
endmodule
"""


LANES: Final[dict[str, Callable[[], str]]] = {
    "ArcTrue quadrant_fold + cordic_rotation": cordic_lane,
    "ArcTrue quadrant_fold + table_rotation": table_lane,
    "table in LUTs and a product in a DSP": table_product_lane,
}


def measure(make: Callable[[], str], folder: Path) -> Measured:
    """Map a lane, estimate its path, and simulate it, all in an empty folder; return the results.
    Raises ToolError if a tool fails."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    source = folder / f"{make.__name__}.v"
    source.write_text(make(), encoding="utf-8")
    mapped = synthesise(source, flatten=True)
    design = Netlist.read(mapped, source.stem)
    paths = longest_paths(design, design.reached())
    used = Design.read(mapped).total(source.stem)
    return Measured(used, max(path.delay_ns for path in paths), *latency_and_errors(sweep(source)))


def _run_tool(command: Sequence[str | Path], folder: Path) -> bytes:
    """Return the standard output of a tool. Raises ToolError if the tool fails."""
    try:
        done = subprocess.run(
            command, cwd=folder, capture_output=True, check=False, timeout=TIMEOUT_S
        )
    except FileNotFoundError as error:
        raise ToolError(f"{command[0]} is missing ({error})") from None
    except subprocess.TimeoutExpired:
        raise ToolError(f"{command[0]} took more than {TIMEOUT_S} s in {folder}") from None
    if done.returncode:
        end = (done.stdout + done.stderr).decode(errors="replace").splitlines()[-12:]
        raise ToolError(f"{command[0]} failed in {folder}:\n" + "\n".join(end))
    return done.stdout


def verilator_version() -> str:
    """Return the version of Verilator. Raises ToolError if Verilator is missing."""
    return _run_tool(["verilator", "--version"], ROOT).decode().split()[1]


def _phases() -> Integers:
    """Return the phases of the sweep, u0.24 turn: 2**20 values spread evenly over the turn; their
    low bits take all values."""
    k = np.arange(1 << SWEEP_BITS, dtype=np.int64)
    shift = PHASE_FRACTION - SWEEP_BITS
    phases: Integers = (k << shift) | (((k * 2654435761) & 0xFFFFFFFF) >> (32 - shift))
    return phases


def sweep(source: Path) -> Integers:
    """Return the outputs of a lane in all clocks, from the clock of the first phase on.

    Raises ToolError if the simulation fails.
    """
    shift = PHASE_FRACTION - SWEEP_BITS
    text = MAIN.format(
        top=source.stem,
        clocks=(1 << SWEEP_BITS) + LATENCIES.stop + SETTLING,
        settling=SETTLING,
        shift=shift,
        low=32 - shift,
        mask=(1 << PHASE_FRACTION) - 1,
    )
    (source.parent / "main.cpp").write_text(text, encoding="utf-8")
    command = ["verilator", "--cc", "--exe", "--build", "-Wno-fatal", "-Wno-lint", "-O3"]
    _run_tool([*command, "--top-module", source.stem, source.name, "main.cpp"], source.parent)
    output = _run_tool([source.parent / "obj_dir" / f"V{source.stem}"], source.parent)
    raw = np.frombuffer(output, dtype=np.int32)[SETTLING:].astype(np.int64)
    half = 1 << (WIDTH - 1)
    signed: Integers = ((raw + half) & (2 * half - 1)) - half
    return signed


def latency_and_errors(outputs: Integers) -> tuple[int, float, float]:
    """Return the latency in clocks, and the two largest errors of the sweep, for a cosine with
    amplitude 1.

    The first error is the largest |cosine - exact| at the phases of the sweep. The second error is
    the largest at these phases and at angles half of the phase's last bit above and below them. The
    latency is one clock more than the delay after which the outputs fit the phases best. Raises
    WrongOutputError if no delay fits.
    """
    phases = _phases()
    errors = {
        delay: _largest_error(outputs[delay : delay + phases.size], phases) for delay in LATENCIES
    }
    delay = min(errors, key=lambda key: errors[key])
    if errors[delay] > LARGEST_ERROR:
        raise WrongOutputError(f"no cosine comes out (off by {errors[delay]:.3g})")
    cosines = outputs[delay : delay + phases.size]
    any_angle = max(
        _largest_error(cosines, phases.astype(np.float64) + side) for side in (-0.5, 0.0, 0.5)
    )
    # The harness reads an output after the clock edge that takes its phase; this adds one register
    # to the delay.
    return delay + 1, errors[delay], any_angle


def _largest_error(cosines: Integers, phases: NDArray[np.floating] | Integers) -> float:
    exact = np.cos(2.0 * np.pi * phases / 2.0**PHASE_FRACTION)
    return float(np.abs(cosines / AMPLITUDE - exact).max())


def table_of(measured: dict[str, Measured]) -> str:
    """Return the table of the page, with the versions of the tools, in Markdown."""
    lines = [
        f"{find_ghdl()[1]}, {find_yosys()[1]} (`synth_xilinx -family xc7 -flatten`), Verilator "
        f"{verilator_version()}.",
        "",
        "| lane | LUT | FF | CARRY4 | DSP | RAMB36 | clocks | longest path, ns | largest error | "
        "at any angle |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for name, found in measured.items():
        used = found.resources
        lines.append(
            f"| {name} | {used.lut} | {used.ff} | {used.carry4} | {used.dsp} | {used.ramb36:g} | "
            f"{found.latency} | {found.path_ns:.1f} | {found.error:.2e} | "
            f"{found.error_any_angle:.2e} |"
        )
    return "\n".join(lines) + "\n"


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure the lanes, print the table, and write it into the page; return the exit code."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--page", type=Path, default=PAGE, help="page with the marks")
    page: Path = parser.parse_args(arguments).page
    try:
        section = MarkedSection(page, BEGIN)
        section.inserted("")  # refuse a page without its marks before the long synthesis
        table = table_of(
            {name: measure(make, WORK / make.__name__) for name, make in LANES.items()}
        )
    except (ToolError, OSError, ValueError) as error:
        print(f"compare_lanes: {error}", file=sys.stderr)
        return 2
    print(table)
    section.write(table)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
