"""Measures one lane: what it takes of the chip, its longest path, its latency and its errors.

Yosys maps the lane's Verilog, scripts/timing_paths.py estimates its longest path, and Verilator
runs it over a sweep of the turn. Each result is written to a file, from which it is read when the
same Verilog is measured again by the same versions of the tools and the same code.
"""

from __future__ import annotations

import hashlib
import json
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from scripts import cell_delays, netlist, resources, timing_paths
from scripts.netlist import ROOT, TimeLimitError, ToolError, find_yosys, synthesise
from scripts.resources import Design, Resources
from scripts.timing_paths import Netlist, longest_paths

WIDTH = 18  # bits of the cosine
SWEEP_BITS = 20  # phases of the sweep
SETTLING = 64  # clocks before the sweep
LATENCIES = range(48)
TIMEOUT_S = 1800
MAP_LIMIT_S = 15.0 * 60.0
CODE = (__file__, cell_delays.__file__, netlist.__file__, resources.__file__, timing_paths.__file__)

MAIN = """
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
    """What a core puts out is not the cosine of any phase before it."""


@dataclass(frozen=True)
class Core:
    """A core to be measured: how its Verilog is made, and what its numbers mean."""

    name: str
    top: str
    origin: str
    make: Callable[[Path, Sequence[Path]], str]
    amplitude: float  # units of the output's last bit at cosine 1
    angle_bits: int
    remark: str
    promised_error: float = 0.01
    """With a larger error the output is refused: it is not the cosine that the core promises."""


@dataclass(frozen=True)
class Measured:
    """What a core takes, its longest path by the estimate, its latency and its largest errors.

    ``error`` is that at the angles that the core takes; ``error_any_angle`` that of any angle,
    which is rounded to one of them.
    """

    resources: Resources
    path_ns: float
    latency: int
    error: float
    error_any_angle: float


def run_tool(command: Sequence[str | Path], folder: Path) -> bytes:
    """What a tool wrote to its standard output. Raises ToolError when it fails."""
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
    """Version of Verilator. Raises ToolError when it is missing."""
    return run_tool(["verilator", "--version"], ROOT).decode().split()[1]


def measure_once(core: Core, source: Path, results: Path, limit_s: float) -> Measured:
    """Measure the Verilog of a core, or read what was measured from the folder ``results``.

    Raises TimeLimitError when Yosys needs more than ``limit_s`` seconds, now or when it was tried
    before; WrongOutputError, and ToolError where a tool fails.
    """
    kept = results / f"{_key(core, source)}.json"
    found = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    if "measured" in found:
        values = found["measured"]
        return Measured(**{**values, "resources": Resources(**values["resources"])})
    if "wrong_output" in found:
        raise WrongOutputError(found["wrong_output"])
    if limit_s <= found.get("not_mapped_in_s", 0.0):
        raise TimeLimitError(limit_s)
    told: dict[str, object] = {"core": core.name, "remark": core.remark}
    try:
        used, path_ns = _map(core, source, limit_s)
    except TimeLimitError:
        _keep(kept, {**told, "not_mapped_in_s": limit_s})
        raise
    try:
        result = Measured(used, path_ns, *latency_and_errors(core, _sweep(core, source)))
    except WrongOutputError as error:
        _keep(kept, {**told, "wrong_output": str(error)})
        raise
    _keep(kept, {**told, "measured": asdict(result)})
    return result


def _keep(file: Path, told: dict[str, object]) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_suffix(".part")
    part.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
    part.replace(file)


def _key(core: Core, source: Path) -> str:
    """Name of a result: a hash of all that it follows from."""
    parts = [
        source.read_text(encoding="utf-8"),
        f"{core.top} {core.amplitude!r} {core.angle_bits} {core.promised_error!r}",
        find_yosys()[1],
        verilator_version(),
        *(Path(file).read_text(encoding="utf-8") for file in CODE),
    ]
    return hashlib.sha256(json.dumps(parts).encode()).hexdigest()[:32]


def _map(core: Core, source: Path, limit_s: float) -> tuple[Resources, float]:
    """What the core takes, and its longest path in ns by the estimate."""
    mapped = synthesise(source, flatten=True, limit_s=limit_s)
    design = Netlist.read(mapped, core.top)
    paths = longest_paths(design, design.reached())
    return Design.read(mapped).total(core.top), max(path.delay_ns for path in paths)


def _phases(core: Core, count: int) -> np.ndarray:
    k = np.arange(count, dtype=np.uint64)
    low = min(core.angle_bits, SWEEP_BITS)
    shift = core.angle_bits - low
    fine = ((k * 2654435761) & 0xFFFFFFFF) >> (32 - shift) if shift else np.zeros_like(k)
    return ((k << np.uint64(shift)) | fine) & ((1 << core.angle_bits) - 1)


def _sweep(core: Core, source: Path) -> np.ndarray:
    """Outputs of all clocks, from that of the first phase on."""
    low = min(core.angle_bits, SWEEP_BITS)
    shift = core.angle_bits - low
    count = (1 << low) + LATENCIES.stop
    text = MAIN.format(
        top=core.top,
        clocks=count + SETTLING,
        settling=SETTLING,
        shift=shift,
        low=32 - shift if shift else 31,
        mask=(1 << core.angle_bits) - 1,
    )
    if not shift:
        text = text.replace(" | (k * 2654435761u >> 31)", "")
    folder = source.parent
    (folder / "main.cpp").write_text(text, encoding="utf-8")
    command = ["verilator", "--cc", "--exe", "--build", "-Wno-fatal", "-Wno-lint", "-O3"]
    run_tool([*command, "--top-module", core.top, source.name, "main.cpp"], folder)
    output = run_tool([folder / "obj_dir" / f"V{core.top}"], folder)
    raw = np.frombuffer(output, dtype=np.int32)[SETTLING:]
    half = 1 << (WIDTH - 1)
    signed: np.ndarray = (raw & (2 * half - 1)).astype(np.int64)
    return np.where(signed >= half, signed - 2 * half, signed)


def latency_and_errors(core: Core, outputs: np.ndarray) -> tuple[int, float, float]:
    """Latency in clocks, and the largest errors of the sweep, of a cosine of size 1.

    The errors are |cosine - exact| at the core's own angles, and at those half of its last bit
    beside them. The latency is the delay at which the outputs fit the phases; raises
    WrongOutputError when none does.
    """
    count = outputs.size - LATENCIES.stop
    turns = _phases(core, count).astype(float) / 2.0**core.angle_bits
    exact = np.cos(2.0 * np.pi * turns)
    errors = {
        delay: float(np.abs(outputs[delay : delay + count] / core.amplitude - exact).max())
        for delay in LATENCIES
    }
    delay = min(errors, key=lambda key: errors[key])
    if errors[delay] > core.promised_error:
        raise WrongOutputError(f"{core.name}: no cosine comes out (off by {errors[delay]:.3g})")
    cosines = outputs[delay : delay + count] / core.amplitude
    half = 0.5 / 2.0**core.angle_bits
    beside = max(
        float(np.abs(cosines - np.cos(2.0 * np.pi * (turns + side))).max())
        for side in (-half, half)
    )
    # An output read after the edge that takes a phase in has been through one register.
    return delay + 1, errors[delay], max(errors[delay], beside)
