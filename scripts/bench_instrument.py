"""Compares the speed of GHDL's two code generators and of the compiled netlist.

The speed is the number of simulated clocks per second of processor time. The compiled netlist is
measured with several numbers of lanes, GHDL with 32 lanes. For the netlist, the rows also state how
long ``arctrue revolution``, with REVOLUTION_CLOCKS clocks, takes at this speed.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from arctrue.instrument import Instrument
from arctrue.instrument.speed import clocks_per_second
from scripts.bench_rows import Row, add_option, give_out

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "build" / "bench"
LANES = (1, 4, 8, 32)
FULL_LANES = 32
CAPTURE_DEPTH = 12288
COMPILED_CLOCKS = 200_000
RUNS, GHDL_RUNS = 7, 3
REVOLUTION_CLOCKS = 40_463_743
"""Number of clocks that ``arctrue revolution`` simulates: two turns of 2²⁴ counts and the way to
the index."""
GHDL_CLOCKS = {"mcode": 300, "llvm": 800}
"""Number of clocks in a measurement, by code generator; a measurement takes some seconds with 32
lanes."""

_CHILD = """
import sys
from tb.support.simulation import simulate
backend, lanes, depth = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
simulate("arctrue_core", "tb.instrument.speed_bench", backend=backend,
         generics={"LANES": lanes, "CAPTURE_DEPTH": depth})
"""


def ghdl_clocks_per_second(backend: str, lanes: int) -> float:
    """Measure the clocks per second of the running simulation, without GHDL's analysis and
    elaboration."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    answer = FOLDER / f"ghdl-{backend}-{lanes}.json"
    answer.unlink(missing_ok=True)
    log = FOLDER / f"ghdl-{backend}-{lanes}.log"
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "sim")]),
        "ARCTRUE_LANES": str(lanes),
        "ARCTRUE_CLOCKS": str(GHDL_CLOCKS[backend]),
        "ARCTRUE_ANSWER": str(answer),
    }
    command = [sys.executable, "-c", _CHILD, backend, str(lanes), str(CAPTURE_DEPTH)]
    with log.open("w", encoding="utf-8") as text:
        done = subprocess.run(
            command, cwd=ROOT, env=environment, stdout=text, stderr=text, check=False
        )
    if done.returncode or not answer.exists():
        sys.exit(f"the simulation with GHDL ({backend}, {lanes} lanes) failed: see {log}")
    result = json.loads(answer.read_text(encoding="utf-8"))
    return float(result["clocks"]) / float(result["cpu_s"])


def compiled(lanes: int) -> tuple[float, ...]:
    """Return the clocks per second of several runs of the compiled netlist."""
    with Instrument(lanes, CAPTURE_DEPTH) as instrument:
        return tuple(clocks_per_second(instrument, lanes, COMPILED_CLOCKS) for _ in range(RUNS))


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure GHDL and the compiled netlist; print the rows of the bench."""
    parser = argparse.ArgumentParser(description=__doc__)
    add_option(parser)
    given = parser.parse_args(arguments)
    ghdl = {
        backend: tuple(ghdl_clocks_per_second(backend, FULL_LANES) for _ in range(GHDL_RUNS))
        for backend in GHDL_CLOCKS
    }
    rows = []
    for lanes in LANES:
        speed = compiled(lanes)
        remark = f"{REVOLUTION_CLOCKS / np.median(speed):.0f} s for `arctrue revolution`"
        if lanes == FULL_LANES:
            remark += "; " + ", ".join(
                f"{np.median(speed) / np.median(found):,.0f} times GHDL {backend}"
                for backend, found in ghdl.items()
            )
        rows.append(Row(f"compiled netlist, {lanes} lanes", "clocks a CPU second", speed, remark))
    rows += [
        Row(
            f"GHDL, {backend}, {FULL_LANES} lanes",
            "clocks a CPU second",
            found,
            "the compiled netlist, above",
        )
        for backend, found in ghdl.items()
    ]
    return give_out(rows, given.rows)


if __name__ == "__main__":
    raise SystemExit(main())
