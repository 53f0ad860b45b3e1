"""Writes fake programs in place of the tools of a flow; they record and check their calls.

Each program reads its input files like the real tool, and fails if a file is missing.
"""

from __future__ import annotations

import json
import os
import stat
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from scripts import bitstream_open
from scripts.bitstream_job import Tool

CALLS = "FAKE_CALLS"
PART = "xc7z020clg400-1"

HEAD = f"""#!{sys.executable}
import json, os, sys
arguments = sys.argv[1:]
name = os.path.basename(sys.argv[0])
with open(os.environ["{CALLS}"], "a") as calls:
    calls.write(json.dumps([name, *arguments]) + "\\n")

def after(option):
    return arguments[arguments.index(option) + 1]

def need(path, text=""):
    content = open(path, errors="replace").read()
    assert text in content, f"{{path}} does not hold {{text}}"
    return content
"""

GHDL = """
if arguments == ["--version"]:
    print("GHDL 5.0.1 (fake)")
elif "--synth" in arguments:
    print("module", arguments[-1], "(input a); endmodule")
elif "-i" in arguments:
    assert all(os.path.exists(word) for word in arguments if word.endswith(".vhd"))
"""

YOSYS = """
import re
if arguments == ["-V"]:
    print("Yosys 0.52 (fake)")
    sys.exit()
script = after("-p")
need(re.search(r"read_verilog (\\S+?);", script)[1], "module")
top = re.search(r"-top (\\w+)", script)[1]
kinds = os.environ.get("FAKE_CELLS", "PS7 BUFG LUT2").split()
nothing = {"port_directions": {"O": "output"}, "connections": {"O": ["0"]}}
cells = {f"cell{n}": {"type": kind, **nothing} for n, kind in enumerate(kinds)}
place = re.search(r"write_json (\\S+)", script)[1]
module = {"ports": {}, "netnames": {}, "cells": cells}
json.dump({"modules": {top: module}}, open(place, "w"))
"""

NEXTPNR = """
if "himbaechel" in name:
    options = dict(word.split("=", 1) for n, word in enumerate(arguments) if arguments[n-1] == "-o")
    assert after("--device") == "xc7z020clg400-1"
else:
    options = {"xdc": after("--xdc"), "fasm": after("--fasm")}
    need(after("--chipdb"))
need(options["xdc"], "set_property LOC Y18 [get_ports head1_a]")
need(after("--json"), "BUFG")
asked = os.environ.get("FAKE_ASKED_MHZ", "100")
assert after("--freq") == asked
line = "Max frequency for clock 'clock': {} MHz ({} at " + asked + ".00 MHz)"
print("Info: " + line.format("88.00", "FAIL"))  # the estimate before routing
reached = os.environ.get("FAKE_MHZ", "143.45")
seed = after("--seed") if "--seed" in arguments else "none"
if seed in os.environ.get("FAKE_SLOW_SEEDS", "").split():
    reached = "99.00"
if reached:
    late = float(reached) < 100
    print(("ERROR: " if late else "Info: ") + line.format(reached, "FAIL" if late else "PASS"))
for slack in os.environ.get("FAKE_HOLD", "").split():
    print("ERROR: Hold/min time violation for clock 'posedge clock':")
    print("Info:   clk-to-q  0.30  0.30 Source core.data.Q")
    print(f"Info:       hold -0.67 {slack} Source core.memory{slack}.DIADI13")
code = int(os.environ.get("FAKE_NEXTPNR_CODE", "0"))
if not code:
    fasm = os.environ.get("FAKE_FASM", "PSS2_X1.PS7.USED[2:0] = 3'b101")
    open(options["fasm"], "w").write(f"# what the processor needs\\n{fasm}\\n")
    json.dump({"modules": {}}, open(after("--write"), "w"))
sys.exit(code)
"""

FASM2FRAMES = """
assert after("--part") == "xc7z020clg400-1"
need(os.path.join(after("--db-root"), after("--part"), "part.yaml"))
need(arguments[-2], "PSS2_X1.PS7")
open(arguments[-1], "w").write("0x00000100 " + "0x0,0x120" + ",0x0" * 99)
"""

FRAMES2BIT = """
assert after("--part_name") in after("--part_file")
need(after("--part_file"))
need(after("--frm_file"), "0x00000100 ")
code = bytes.fromhex(os.environ.get("FAKE_IDCODE", "03727093"))
with open(after("--output_file"), "wb") as bitstream:
    bitstream.write(bytes(50) + bytes.fromhex("aa995566 20000000 30018001") + code)
    words_stated = int(os.environ.get("FAKE_WORDS", "1010808"))  # as Project X-Ray writes
    bitstream.write(bytes.fromhex("30004000") + (0x50000000 | words_stated).to_bytes(4, "big"))
    bitstream.write(bytes(4 * int(os.environ.get("FAKE_WORDS_THERE", words_stated))))
"""

VIVADO = """
import subprocess
prelude = os.environ["FAKE_VIVADO_PRELUDE"]
script = after("-source")
words = arguments[arguments.index("-tclargs") + 1:]
sys.exit(subprocess.run(["tclsh", prelude, script, *words]).returncode)
"""

OPEN_TOOLS = {
    "ghdl": GHDL,
    "yosys": YOSYS,
    "nextpnr-himbaechel": NEXTPNR,
    "xc7frames2bit": FRAMES2BIT,
}

# The files are Project X-Ray's database of a chip with a single tile.
GRID = {
    "PSS2_X1": {
        "type": "PSS2",
        "bits": {
            "CLB_IO_CLK": {"baseaddr": "0x00000100", "frames": 2, "offset": 1, "words": 2},
        },
    }
}
SEGBITS = """PSS2.PS7.USED[0] 00_05
PSS2.PS7.USED[1] 00_06
PSS2.PS7.USED[2] 00_08 !01_33
PSS2.PS7.ALONE 01_33
"""


def add_database(folder: Path) -> Path:
    """Write a small database for the chip's family; return the path of its folder."""
    family = folder / "prjxray-db" / "zynq7"
    (family / PART).mkdir(parents=True)
    (family / PART / "part.yaml").write_text("part", encoding="utf-8")
    (family / "xc7z020").mkdir()
    (family / "xc7z020" / "tilegrid.json").write_text(json.dumps(GRID), encoding="utf-8")
    (family / "segbits_pss2.db").write_text(SEGBITS, encoding="utf-8")
    (family / "ppips_pss2.db").write_text("PSS2.PS7.WIRE always\n", encoding="utf-8")
    return family


class FakeTools:
    """Folder of fake programs, which is the first folder in PATH, and the record of their calls."""

    def __init__(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        self.folder = folder
        self.monkeypatch = monkeypatch
        self.programs = folder / "programs"
        self.programs.mkdir()
        self.calls_file = folder / "calls"
        monkeypatch.setenv(CALLS, str(self.calls_file))
        for variable in ("NEXTPNR", "FASM2FRAMES", "XC7FRAMES2BIT", "VIVADO", "CHIPDB"):
            monkeypatch.delenv(variable, raising=False)
        for tool in ("NEXTPNR", "FRAMES2BIT"):
            unpacked: Tool = getattr(bitstream_open, tool)
            monkeypatch.setattr(bitstream_open, tool, replace(unpacked, folder=None))
        monkeypatch.setattr(bitstream_open, "UNPACKED", folder / "not_unpacked")
        self.set_path()

    def set_path(self, *more: str) -> None:
        """Set PATH so that it contains the fake programs and the programs that the tests need, but
        no real tool of a flow."""
        self.monkeypatch.setenv("PATH", os.pathsep.join([str(self.programs), *more]))

    def add(self, name: str, text: str) -> Path:
        path = self.programs / name
        path.write_text(HEAD + text, encoding="utf-8")
        path.chmod(path.stat().st_mode | stat.S_IXUSR)
        return path

    def add_open_tools(self) -> None:
        for name, text in OPEN_TOOLS.items():
            self.add(name, text)
        self.monkeypatch.setenv("GHDL_NETLIST", str(self.programs / "ghdl"))
        self.monkeypatch.setenv("YOSYS", str(self.programs / "yosys"))
        add_database(self.folder)
        self.monkeypatch.setenv("PRJXRAY_DB_DIR", str(self.folder / "prjxray-db"))

    def calls(self, name: str) -> list[list[str]]:
        """Return the arguments of every call of one program."""
        if not self.calls_file.exists():
            return []
        lines: list[Any] = [
            json.loads(line) for line in self.calls_file.read_text(encoding="utf-8").splitlines()
        ]
        return [line[1:] for line in lines if line[0] == name]
