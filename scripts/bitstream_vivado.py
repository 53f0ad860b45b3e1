"""Makes a bitstream with Vivado: one batch run of scripts/bitstream_vivado.tcl."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

from scripts.bitstream_job import CONSTRAINTS, Job, TimingError, Tool, all_found, in_order_of_use
from scripts.netlist import ToolError, sources_of

VIVADO = Tool(
    "VIVADO",
    ("vivado",),
    "Install AMD Vivado ML Standard (free for the XC7Z020) and source its settings64.sh; "
    "or name it: VIVADO=/path/to/vivado; or take FLOW=open",
)
SCRIPT = Path(__file__).with_name("bitstream_vivado.tcl")
NOT_MET = re.compile(r"^ARCTRUE TIMING NOT MET: (.*)$", re.MULTILINE)
SHOWN_LINES = 15


def run_vivado(job: Job) -> str:
    """Make the bitstream of a job with Vivado; return a sentence about the timing.

    Raises ToolError if Vivado is missing or fails, TimingError if the timing is not met.
    """
    (vivado,) = all_found([VIVADO])
    job.reports.mkdir(parents=True)
    sources = in_order_of_use(sources_of(job.top.name))
    arguments = ["-top", job.top.name, "-part", job.part, "-output", str(job.folder)]
    for name, value in job.generics.items():
        word = f'"{value}"' if isinstance(value, str) else str(value).lower()
        arguments += ["-generic", f"{name}={word}"]
    folder = CONSTRAINTS / "vivado"
    for entity in job.top.scoped:
        arguments += ["-scoped", str(folder / f"{entity}.xdc")]
    for xdc in (job.pins, folder / f"{job.top.vivado}.xdc"):
        arguments += ["-xdc", str(xdc)]
    for path in sources:
        arguments += ["-vhdl", str(path)]
    log = job.reports / "vivado.log"
    command = [vivado, "-mode", "batch", "-nojournal", "-notrace", "-log", str(log)]
    command += ["-source", str(SCRIPT), "-tclargs", *arguments]
    done = subprocess.run(
        command, cwd=job.folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )
    output = done.stdout
    (job.reports / "vivado.console.log").write_text(output, encoding="utf-8")
    if late := NOT_MET.search(output):
        raise TimingError(f"{late[1]} See {job.reports / 'timing.rpt'}.")
    if done.returncode:
        tail = "\n".join(output.splitlines()[-SHOWN_LINES:])
        raise ToolError(f"Vivado failed. The end of {log}:\n{tail}")
    met = re.search(r"^ARCTRUE TIMING MET: (.*)$", output, re.MULTILINE)
    if not met:
        raise ToolError(f"Vivado ended without a statement on the timing; see {log}")
    return met[1]
