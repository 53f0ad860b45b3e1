"""Clocks in a second of processor time: GHDL's two code generators against the compiled netlist.

And how that grows with the lanes, and how long a revolution at the paper's size takes.
``python -m scripts.bench_instrument [--quick]``; --quick leaves the revolution out.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path

from arctrue.instrument import Instrument, RevolutionSettings, run_revolution
from arctrue.instrument.speed import clocks_per_second

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "build" / "bench"
LANES = (1, 4, 8, 32)
FULL_LANES = 32
CAPTURE_DEPTH = 12288
COMPILED_CLOCKS = 200_000
GHDL_CLOCKS = {"mcode": 300, "llvm": 800}
"""Enough for some seconds with 32 lanes."""

_CHILD = """
import sys
from tb.support.simulation import simulate
backend, lanes, depth = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
simulate("arctrue_core", "tb.instrument.speed_bench", backend=backend,
         generics={"LANES": lanes, "CAPTURE_DEPTH": depth})
"""


def ghdl_clocks_per_second(backend: str, lanes: int) -> float:
    """Measured inside the simulation, without analysis and elaboration."""
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
    told = json.loads(answer.read_text(encoding="utf-8"))
    return float(told["clocks"]) / float(told["cpu_s"])


def compiled(lanes: int) -> tuple[float, float]:
    """Clocks a second, and seconds to build (0: it was there)."""
    started = time.perf_counter()
    with Instrument(lanes, CAPTURE_DEPTH) as instrument:
        built_s = time.perf_counter() - started
        return clocks_per_second(instrument, lanes, COMPILED_CLOCKS), built_s


def main() -> None:
    """Print the tables and write build/bench/instrument.json."""
    quick = "--quick" in sys.argv[1:]
    print(f"{'lanes':>6}{'compiled, clocks/s':>20}{'made ready in s':>17}")
    speeds = {}
    for lanes in LANES:
        speeds[lanes], built_s = compiled(lanes)
        print(f"{lanes:6}{speeds[lanes]:20,.0f}{built_s:17.1f}", flush=True)
    print(f"\n{FULL_LANES} lanes{'clocks/s':>22}{'compiled is faster by':>24}")
    simulators = {}
    for backend in GHDL_CLOCKS:
        simulators[backend] = ghdl_clocks_per_second(backend, FULL_LANES)
        factor = speeds[FULL_LANES] / simulators[backend]
        print(f"  GHDL {backend:8}{simulators[backend]:15,.0f}{factor:24,.0f}", flush=True)
    found = {"compiled": speeds, "ghdl": simulators}
    if not quick:
        result = run_revolution(RevolutionSettings())
        print(
            f"\na revolution of 2^24 counts with 32 lanes, two turns and the way to the index: "
            f"{result.clocks:,} clocks in {result.wall_s:.0f} s; "
            f"left: {result.after.lowest_arcsec:.3f}″ to {result.after.highest_arcsec:.3f}″"
        )
        found["revolution"] = {"wall_s": result.wall_s, "clocks": result.clocks}
    (FOLDER / "instrument.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
