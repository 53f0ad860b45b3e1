"""Makes a Verilog netlist from VHDL with GHDL.

Simulations use the system's GHDL. A netlist needs GHDL 5 or newer, because older versions write
wrong Verilog: 2.0 drops `when others` (GHDL issue 2041), 4.1 shifts signed numbers to the right
without sign extension (issue 2750).
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

from arctrue.base.source_tree import ROOT

SOURCE_FOLDERS = (ROOT / "build" / "generated" / "vhdl", ROOT / "rtl")
OLDEST_GHDL = 5


class ToolError(Exception):
    """A tool is missing or failed; the text names the tool, and the remedy or the end of the tool's
    log."""


def _version_of_ghdl(command: str) -> tuple[int, str] | None:
    try:
        done = subprocess.run([command, "--version"], capture_output=True, text=True, check=False)
    except OSError:
        return None
    found = re.match(r"GHDL (\d+)\.\S+", done.stdout)
    return (int(found[1]), found[0]) if found else None


def find_ghdl() -> tuple[str, str]:
    """Search $GHDL_NETLIST, build/ghdl5 and PATH for a GHDL that makes correct netlists.

    Returns command and version. Raises ToolError if there is none.
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


def sources_of(entity: str, folders: Sequence[Path] = SOURCE_FOLDERS) -> list[Path]:
    """Return the VHDL files that ``entity`` needs; a file has the name of its entity or package.

    Raises ToolError if a file is missing.
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


def _generic(value: int | str | bool) -> str:
    """Return a generic's value as text for GHDL, with booleans in lower case (true, false)."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def write_netlist(
    entity: str,
    folder: Path,
    *,
    generics: Mapping[str, int | str | bool] | None = None,
    folders: Sequence[Path] = SOURCE_FOLDERS,
) -> Path:
    """Write ``folder/<entity>.v``, the Verilog netlist of ``entity``, and return its path.

    ``folder`` is emptied first. Raises ToolError.
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
    values = [f"-g{name}={_generic(value)}" for name, value in (generics or {}).items()]
    # GHDL translates VHDL asserts to $fatal, which Yosys cannot read.
    command = [ghdl, "--synth", "--no-formal", *options, "--out=verilog", *values, entity]
    _run(command, netlist, log, f"The netlist of {entity}")
    return netlist
