"""The open flow: GHDL, Yosys, nextpnr, FASM, Project X-Ray's bitstream tools."""

from __future__ import annotations

import json
import os
import re
import subprocess
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from scripts.bitstream_job import Job, TimingError, Tool, Top, all_found
from scripts.netlist import ToolError, find_ghdl, find_yosys, synthesise, write_netlist

NEXTPNR = Tool(
    "NEXTPNR",
    ("nextpnr-himbaechel", "nextpnr-xilinx"),
    "Build nextpnr with its himbaechel/xilinx architecture (github.com/YosysHQ/nextpnr), or "
    "nextpnr-xilinx (github.com/openXC7/nextpnr-xilinx); or name it: NEXTPNR=/path/to/nextpnr-...",
)
FASM2FRAMES = Tool(
    "FASM2FRAMES",
    ("fasm2frames", "fasm2frames.py"),
    "It is utils/fasm2frames.py of Project X-Ray (github.com/f4pga/prjxray); "
    "or name it: FASM2FRAMES=/path/to/fasm2frames",
)
FRAMES2BIT = Tool(
    "XC7FRAMES2BIT",
    ("xc7frames2bit",),
    "Build it from Project X-Ray (github.com/f4pga/prjxray), folder tools; "
    "or name it: XC7FRAMES2BIT=/path/to/xc7frames2bit",
)
DATABASE = "PRJXRAY_DB_DIR"
CHIPDB = "CHIPDB"
FAMILY = "zynq7"
SHOWN_LINES = 15

FREQUENCY = re.compile(
    r"Max frequency for clock\s+'(?P<clock>[^']+)': (?P<reached>[\d.]+) MHz "
    r"\((?P<verdict>PASS|FAIL) at (?P<asked>[\d.]+) MHz\)"
)


def is_himbaechel(nextpnr: str) -> bool:
    """Which of the two nextpnr, by the program's name: their options differ."""
    return "himbaechel" in Path(nextpnr).name


def database_of(part: str) -> tuple[Path | None, str]:
    """Project X-Ray's folder of the family, or None and what to do."""
    named = os.environ.get(DATABASE)
    if not named:
        return None, (
            f"{DATABASE} is not set. Clone github.com/f4pga/prjxray-db and set "
            f"{DATABASE}=/path/to/prjxray-db"
        )
    family = Path(named) / FAMILY
    description = family / part / "part.yaml"
    if not description.exists():
        return None, f"{DATABASE}={named} does not know the part {part}: no {description}"
    return family, ""


def chip_database(nextpnr: str | None) -> tuple[str | None, str]:
    """nextpnr's own database where it is named, and what to do where one is needed and is not."""
    named = os.environ.get(CHIPDB)
    if named and not Path(named).exists():
        return None, f"{CHIPDB}={named}: there is no such file"
    if nextpnr and not named and not is_himbaechel(nextpnr):
        return None, (
            f"{CHIPDB} is not set: nextpnr-xilinx needs the chip's database. Make it with its "
            f"bbaexport.py and bbasm and set {CHIPDB}=/path/to/xc7z020.bin"
        )
    return named, ""


def timing_of(log: str) -> dict[str, tuple[float, str]]:
    """Clock to what it reached in MHz and the verdict: the last one, which is after routing."""
    return {
        found["clock"]: (float(found["reached"]), found["verdict"])
        for found in FREQUENCY.finditer(log)
    }


def check_primitives(netlist: Path, top: Top) -> None:
    """Raise ToolError when the mapped netlist has not the cells that tie it to the chip."""
    modules = json.loads(netlist.read_text(encoding="utf-8"))["modules"]
    cells = Counter(cell["type"] for cell in modules[top.name]["cells"].values())
    for kind, count in top.primitives.items():
        if cells[kind] != count:
            raise ToolError(f"{netlist}: expected {count} {kind}, found {cells[kind]}")


def _run(command: Sequence[str], log: Path) -> tuple[int, str]:
    done = subprocess.run(
        command, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False
    )
    log.write_text(f"{' '.join(command)}\n{done.stdout}", encoding="utf-8")
    return done.returncode, done.stdout


def _failed(command: str, log: Path, told: str) -> ToolError:
    tail = "\n".join(told.splitlines()[-SHOWN_LINES:])
    return ToolError(f"{command} failed. The end of {log}:\n{tail}")


def place_and_route(job: Job, nextpnr: str, chipdb: str | None, netlist: Path) -> tuple[Path, str]:
    """Run nextpnr; the FASM file and a sentence about the timing.

    Raises ToolError when nextpnr fails or times nothing, TimingError when a clock is too slow.
    """
    fasm = job.folder / "arctrue.fasm"
    command = [nextpnr]
    if is_himbaechel(nextpnr):
        command += ["--device", job.part, *(["--chipdb", chipdb] if chipdb else [])]
        command += ["-o", f"xdc={job.pins}", "-o", f"fasm={fasm}"]
    else:
        command += ["--chipdb", str(chipdb), "--xdc", str(job.pins), "--fasm", str(fasm)]
    command += ["--json", str(netlist), "--freq", str(job.top.clock_mhz)]
    log = job.reports / "nextpnr.log"
    code, told = _run(command, log)
    clocks = timing_of(told)
    late = {clock: reached for clock, (reached, verdict) in clocks.items() if verdict == "FAIL"}
    if late:
        worst = ", ".join(f"{clock} {reached:g} MHz" for clock, reached in late.items())
        raise TimingError(
            f"nextpnr's estimate is below {job.top.clock_mhz} MHz: {worst}. "
            f"Take fewer LANES or more FOLD. See {log}."
        )
    if code:
        raise _failed(nextpnr, log, told)
    if not clocks:
        raise ToolError(f"nextpnr timed no clock; see {log}")
    if not fasm.exists():
        raise ToolError(f"nextpnr wrote no {fasm}; see {log}")
    reached = ", ".join(f"{clock} {value:g} MHz" for clock, (value, _) in clocks.items())
    return fasm, f"nextpnr's estimate, which times no block RAM, DSP or PS7 in full: {reached}"


def run_open(job: Job) -> str:
    """Make the bitstream and return a sentence about the timing.

    Raises ToolError for what is missing (all at once) or fails, TimingError for a slow clock.
    """
    missing = []
    for find in (find_ghdl, find_yosys):
        try:
            find()
        except ToolError as error:
            missing.append(str(error))
    chipdb, no_chipdb = chip_database(NEXTPNR.find())
    family, no_family = database_of(job.part)
    others = [*missing, *(text for text in (no_chipdb, no_family) if text)]
    nextpnr, fasm2frames, frames2bit = all_found([NEXTPNR, FASM2FRAMES, FRAMES2BIT], others)
    assert family is not None

    job.reports.mkdir(parents=True)
    print(f"bitstream: netlist of {job.top.name} (GHDL, Yosys)", flush=True)
    verilog = write_netlist(job.top.name, job.folder / "netlist", generics=job.generics)
    netlist = synthesise(verilog, flatten=True)
    check_primitives(netlist, job.top)
    print(f"bitstream: place and route ({Path(nextpnr).name})", flush=True)
    fasm, timing = place_and_route(job, nextpnr, chipdb, netlist)
    print("bitstream: frames and bitstream (Project X-Ray)", flush=True)
    frames = job.folder / "arctrue.frames"
    for command, log in (
        (
            [fasm2frames, "--part", job.part, "--db-root", str(family), str(fasm), str(frames)],
            job.reports / "fasm2frames.log",
        ),
        (
            [
                frames2bit,
                *("--part_file", str(family / job.part / "part.yaml")),
                *("--part_name", job.part),
                *("--frm_file", str(frames)),
                *("--output_file", str(job.bitstream)),
            ],
            job.reports / "xc7frames2bit.log",
        ),
    ):
        code, told = _run(command, log)
        if code:
            raise _failed(command[0], log, told)
    return timing
