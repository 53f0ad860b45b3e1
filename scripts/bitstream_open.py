"""Makes a bitstream with GHDL, Yosys, nextpnr, and Project X-Ray's database and writer."""

from __future__ import annotations

import json
import os
import re
import subprocess
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from scripts.bitstream_database import Chip
from scripts.bitstream_features import Features, bits_of_frames
from scripts.bitstream_job import Job, TimingError, Tool, Top, all_found
from scripts.bitstream_pins import check_pins_driven
from scripts.bitstream_routes import Routes
from scripts.bitstream_ties import tie_constants
from scripts.bitstream_tristates import add_straight_enables
from scripts.fasm_frames import frames_of
from scripts.netlist import ROOT, ToolError, find_ghdl, find_yosys, synthesise, write_netlist

UNPACKED = ROOT / "build" / "place_and_route"
"""Folder into which scripts/install_place_and_route.sh unpacks nextpnr and the database."""
INSTALL = "Run scripts/install_place_and_route.sh, "
NEXTPNR = Tool(
    "NEXTPNR",
    ("nextpnr-himbaechel", "nextpnr-himbaechel-xilinx", "nextpnr-xilinx"),
    f"{INSTALL}or build nextpnr with its himbaechel/xilinx architecture "
    "(github.com/YosysHQ/nextpnr); or name it: NEXTPNR=/path/to/nextpnr-...",
    UNPACKED / "bin",
)
FRAMES2BIT = Tool(
    "XC7FRAMES2BIT",
    ("xc7frames2bit",),
    f"{INSTALL}or build Project X-Ray's (github.com/f4pga/prjxray, folder tools); "
    "or name it: XC7FRAMES2BIT=/path/to/xc7frames2bit",
    UNPACKED / "bin",
)
FASM2FRAMES = Tool("FASM2FRAMES", (), "It is utils/fasm2frames.py of github.com/f4pga/prjxray")
"""Project X-Ray's fasm2frames, which is used only if the user names it. scripts/fasm_frames.py does
the same, but not for banks below 3.3 V."""
DATABASE = "PRJXRAY_DB_DIR"
CHIPDB = "CHIPDB"
FAMILY = "zynq7"
WITHOUT_CONTENTS = ("RAM32M", "RAM64M")
SHOWN_LINES = 15
PLACEMENT = ("--placer-heap-timingweight", "50", "--placer-heap-critexp", "4")
"""Options for nextpnr's placer that give wires on long paths more weight than the defaults, 10 and
2 (docs/timing.md)."""
ROUTING = ("--tmg-ripup",)
"""Option that lets nextpnr's router route a wire again if a detour of the wire makes a path too
slow."""

OTHER_SEEDS = (2, 3)
"""Seeds of the placements that are tried if the first placement does not meet the timing."""

FREQUENCY = re.compile(
    r"Max frequency for clock\s+'(?P<clock>[^']+)': (?P<reached>[\d.]+) MHz "
    r"\((?P<verdict>PASS|FAIL) at (?P<asked>[\d.]+) MHz\)"
)
HOLD = re.compile(r"hold\s+-?[\d.]+\s+(?P<slack>-[\d.]+)\s+Source (?P<pin>\S+)")


def is_himbaechel(nextpnr: str) -> bool:
    """Tell from its name whether a program is nextpnr-himbaechel; nextpnr-xilinx has other
    options."""
    return "himbaechel" in Path(nextpnr).name


def database_of(part: str) -> tuple[Path | None, str]:
    """Return Project X-Ray's folder of the family, or None, and advice for a missing folder."""
    named = os.environ.get(DATABASE)
    folder = Path(named) if named else UNPACKED / "database"
    if not named and not folder.exists():
        return None, (
            f"{DATABASE} is not set. {INSTALL}or clone github.com/f4pga/prjxray-db and set "
            f"{DATABASE}=/path/to/prjxray-db"
        )
    family = folder / FAMILY
    description = family / part / "part.yaml"
    if not description.exists():
        return None, f"{folder} does not know the part {part}: no {description}"
    return family, ""


def chip_database(nextpnr: str | None) -> tuple[str | None, str]:
    """Return the path of nextpnr's own database or None, and advice if it is required and missing.

    The user names the database, or scripts/install_place_and_route.sh has unpacked it with nextpnr.
    """
    named = os.environ.get(CHIPDB)
    if named and not Path(named).exists():
        return None, f"{CHIPDB}={named}: there is no such file"
    unpacked = UNPACKED / "chipdb-xc7z020.bin"
    if nextpnr and not named and Path(nextpnr).is_relative_to(UNPACKED):
        return str(unpacked), ""
    if nextpnr and not named and not is_himbaechel(nextpnr):
        return None, (
            f"{CHIPDB} is not set: nextpnr-xilinx needs the chip's database. Make it with its "
            f"bbaexport.py and bbasm and set {CHIPDB}=/path/to/xc7z020.bin"
        )
    return named, ""


def timing_of(log: str) -> dict[str, tuple[float, str]]:
    """Return the frequency of each clock in MHz and nextpnr's last verdict on it, which is the one
    after routing."""
    return {
        found["clock"]: (float(found["reached"]), found["verdict"])
        for found in FREQUENCY.finditer(log)
    }


def hold_violations(log: str) -> list[tuple[float, str]]:
    """Return the negative slack in ns, and the pin, of each hold violation that nextpnr reports."""
    return [(float(found["slack"]), found["pin"]) for found in HOLD.finditer(log)]


def check_timing(log: str, path: Path, asked_mhz: float) -> None:
    """Raise TimingError if nextpnr's log reports a clock that is too slow, or a hold violation.

    The message names ``path``, where the log is.
    """
    clocks = timing_of(log)
    late = {clock: reached for clock, (reached, verdict) in clocks.items() if verdict == "FAIL"}
    if late:
        worst = ", ".join(f"{clock} {reached:g} MHz" for clock, reached in late.items())
        raise TimingError(
            f"nextpnr's estimate is below {asked_mhz} MHz: {worst}. "
            f"Take fewer LANES or a larger FOLD. See {path}."
        )
    early = hold_violations(log)
    if early:
        slack, pin = min(early)
        raise TimingError(
            f"nextpnr's estimate has {len(early)} hold violations, the worst {slack:g} ns at "
            f"{pin}. Try another placement: make bitstream FLOW=open SEED=N. See {path}."
        )


def check_primitives(netlist: Path, top: Top) -> None:
    """Raise ToolError if the numbers of the cells that connect the mapped netlist to the chip are
    wrong."""
    modules = json.loads(netlist.read_text(encoding="utf-8"))["modules"]
    cells = Counter(cell["type"] for cell in modules[top.name]["cells"].values())
    for kind, count in top.primitives.items():
        if cells[kind] != count:
            raise ToolError(f"{netlist}: expected {count} {kind}, found {cells[kind]}")


def check_contents(netlist: Path, top: Top) -> None:
    """Raise ToolError if a look-up table as RAM contains ones at power-up, because nextpnr would
    lose these contents.

    nextpnr reads the contents of a RAM32M or RAM64M from ``INITA``, but the cell has ``INIT_A``.
    """
    modules = json.loads(netlist.read_text(encoding="utf-8"))["modules"]
    for name, cell in modules[top.name]["cells"].items():
        if cell["type"] not in WITHOUT_CONTENTS:
            continue
        for parameter, value in cell["parameters"].items():
            if parameter.startswith("INIT_") and "1" in str(value):
                raise ToolError(
                    f"{netlist}: the {cell['type']} {name} holds ones at power-up, which nextpnr "
                    "loses: start that memory with zeros, or write it after a reset"
                )


def _run(command: Sequence[str], log: Path) -> tuple[int, str]:
    """Run a command; return exit code and output. The output is also written to the log while the
    command runs."""
    with log.open("w", encoding="utf-8") as file:
        file.write(f"{' '.join(command)}\n")
        file.flush()
        done = subprocess.run(command, stdout=file, stderr=subprocess.STDOUT, check=False)
    return done.returncode, log.read_text(encoding="utf-8", errors="replace")


def _failed(command: str, log: Path, output: str) -> ToolError:
    tail = "\n".join(output.splitlines()[-SHOWN_LINES:])
    return ToolError(f"{command} failed. The end of {log}:\n{tail}")


def _run_step(job: Job, name: str, command: Sequence[str]) -> None:
    log = job.reports / f"{name}.log"
    code, output = _run(command, log)
    if code:
        raise _failed(command[0], log, output)


@dataclass(frozen=True)
class Routed:
    """Results of place and route: FASM, placed netlist and a sentence about the timing."""

    fasm: Path
    netlist: Path
    timing: str


def place_and_route(job: Job, nextpnr: str, chipdb: str | None, netlist: Path) -> Routed:
    """Run nextpnr once on a netlist; return the results.

    Raises ToolError if nextpnr fails or reports no timing, TimingError for a clock that is too slow
    or a hold violation.
    """
    fasm = job.folder / "arctrue.fasm"
    routed = job.folder / "arctrue.routed.json"
    command = [nextpnr]
    if is_himbaechel(nextpnr):
        command += ["--device", job.part, *(["--chipdb", chipdb] if chipdb else [])]
        command += ["-o", f"xdc={job.pins}", "-o", f"fasm={fasm}"]
        command += (*PLACEMENT, *ROUTING) if job.top.has_core else ()
    else:
        command += ["--chipdb", str(chipdb), "--xdc", str(job.pins), "--fasm", str(fasm)]
    command += ["--json", str(netlist), "--write", str(routed)]
    command += ["--freq", str(job.top.clock_mhz)]
    command += ["--seed", str(job.seed)] if job.seed is not None else []
    log = job.reports / "nextpnr.log"
    code, output = _run(command, log)
    clocks = timing_of(output)
    check_timing(output, log, job.top.clock_mhz)
    if code:
        raise _failed(nextpnr, log, output)
    if not clocks:
        raise ToolError(f"nextpnr timed no clock; see {log}")
    for made in (fasm, routed):
        if not made.exists():
            raise ToolError(f"nextpnr wrote no {made}; see {log}")
    reached = ", ".join(f"{clock} {value:g} MHz" for clock, (value, _) in clocks.items())
    timing = f"nextpnr's estimate, with incomplete delays of block RAM, DSP and PS7: {reached}"
    return Routed(fasm, routed, timing)


def place_until_timed(job: Job, nextpnr: str, chipdb: str | None, netlist: Path) -> Routed:
    """Run nextpnr; if the timing is not met and the job has no seed, run it again with other seeds.

    Raises ToolError if nextpnr fails, TimingError if no placement meets the timing.
    """
    for seed in OTHER_SEEDS if job.seed is None else ():
        try:
            return place_and_route(job, nextpnr, chipdb, netlist)
        except TimingError as error:
            print(f"bitstream: {error} The next placement is that of seed {seed}.", flush=True)
            job = replace(job, seed=seed)
    return place_and_route(job, nextpnr, chipdb, netlist)


@dataclass(frozen=True)
class OpenTools:
    """Paths of the programs that run after Yosys; ``fasm2frames`` is among them only if the user
    names it."""

    nextpnr: str
    chipdb: str | None
    frames2bit: str
    family: Path
    fasm2frames: str | None


def find_open_tools(part: str) -> OpenTools:
    """Find all programs of the open flow; return those that run after Yosys.

    Raises ToolError, which names all missing programs at once, also GHDL and Yosys.
    """
    missing = []
    for find in (find_ghdl, find_yosys):
        try:
            find()
        except ToolError as error:
            missing.append(str(error))
    chipdb, no_chipdb = chip_database(NEXTPNR.find())
    family, no_family = database_of(part)
    others = [*missing, *(text for text in (no_chipdb, no_family) if text)]
    named = [FASM2FRAMES] if os.environ.get(FASM2FRAMES.variable) else []
    nextpnr, frames2bit, *fasm2frames = all_found([NEXTPNR, FRAMES2BIT, *named], others)
    assert family is not None
    return OpenTools(nextpnr, chipdb, frames2bit, family, next(iter(fasm2frames), None))


def write_frames(job: Job, tools: OpenTools, routed: Routed) -> Path:
    """Make the frames of a routed design with the features that nextpnr omits, and check that every
    pin is driven.

    Raises ToolError for a feature that the database does not have and for an undriven pin.
    """
    chip = Chip(tools.family, job.part)
    fasm = job.folder / "arctrue.tied.fasm"
    tie_constants(routed.fasm, routed.netlist, chip, fasm)
    add_straight_enables(fasm)
    frames = job.folder / "arctrue.frames"
    if tools.fasm2frames:
        options = ["--part", job.part, "--db-root", str(tools.family), str(fasm), str(frames)]
        _run_step(job, "fasm2frames", [tools.fasm2frames, *options])
    else:
        frames_of(fasm, chip).write(frames)
    check_pins_driven(Routes(Features(chip, bits_of_frames(frames))))
    return frames


def write_bitstream_of(job: Job, tools: OpenTools, routed: Routed) -> None:
    """Make the bitstream of a routed design. Raises ToolError if a step fails."""
    frames = write_frames(job, tools, routed)
    options = ["--part_file", str(tools.family / job.part / "part.yaml")]
    options += ["--part_name", job.part, "--frm_file", str(frames)]
    options += ["--output_file", str(job.bitstream)]
    _run_step(job, "xc7frames2bit", [tools.frames2bit, *options])


def write_bitstream(job: Job, tools: OpenTools, netlist: Path) -> str:
    """Make the bitstream of a mapped netlist; return a sentence about the timing.

    Raises ToolError if a step fails, TimingError if the timing is not met.
    """
    log = job.reports / "nextpnr.log"
    print(f"bitstream: place and route ({Path(tools.nextpnr).name}); log: {log}", flush=True)
    routed = place_until_timed(job, tools.nextpnr, tools.chipdb, netlist)
    print("bitstream: frames and bitstream (Project X-Ray)", flush=True)
    write_bitstream_of(job, tools, routed)
    return routed.timing


def run_open(job: Job) -> str:
    """Make the bitstream of a job with the open tools; return a sentence about the timing.

    Raises ToolError if a step fails or if programs are missing (the message names all), TimingError
    if the timing is not met.
    """
    tools = find_open_tools(job.part)
    job.reports.mkdir(parents=True)
    print(f"bitstream: netlist of {job.top.name} (GHDL, Yosys)", flush=True)
    # nextpnr-himbaechel 0.11.1 does not support the primitive DNA_PORT.
    generics = {**job.generics, "DNA_PORTS": 0} if job.top.has_core else job.generics
    verilog = write_netlist(job.top.name, job.folder / "netlist", generics=generics)
    netlist = synthesise(verilog, flatten=True, for_nextpnr=True)
    check_primitives(netlist, job.top)
    check_contents(netlist, job.top)
    return write_bitstream(job, tools, netlist)
