"""Counts the lines of ``rtl/`` that the benches execute: ``make coverage-gateware``.

The benches of ``tb/`` run in GHDL 5, which counts the lines of executed statements (``--coverage``
of its mcode back-end); each simulation writes a JSON file. A line counts as executed if any
simulation executed it. The script writes coverage.md, and the lines that no simulation executes,
into build/coverage_gateware. GHDL 5 simulates more slowly than the GHDL that the tests use.
Therefore the longest benches are left out (``BENCHES``); other benches execute the same lines,
and with the longest benches the share could only be larger. Exit code 1: a bench fails, a file
of ``rtl/`` is in no simulation, or the budget is missed. 2: a tool is missing, a JSON file is
incomplete, or the benches take too long.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from scripts.netlist import ROOT, ToolError, find_ghdl

FOLDER: Final = ROOT / "build" / "coverage_gateware"
BUDGET: Final = 0.95
"""Smallest permitted share of the lines with statements in ``rtl/`` that the benches execute."""
BENCHES: Final = (
    "tb",
    # These benches run the whole instrument; the benches of the units and of the core execute the
    # same lines.
    *(f"--ignore=tb/{folder}" for folder in ("demo", "firmware", "instrument")),
    # These benches run thousands of angles through 32 lanes; 2 to 8 lanes execute the same lines.
    *(
        f"--deselect=tb/core/test_compensation_pipeline.py::{test}"
        for test in (
            "test_a_turn_of_12000_angles_with_the_default_lanes",
            "test_32_lanes_folded_by_4",
        )
    ),
)
"""Arguments of pytest that select the benches whose lines are counted."""
VARIABLE: Final = "ARCTRUE_COVERAGE"
"""Environment variable that states the folder of the results to tb/support/simulation.py."""
RUN_LIMIT_S: Final = 4 * 3600


@dataclass
class FileLines:
    """Lines of one file that have statements, and the executed lines among them."""

    lines: set[int] = field(default_factory=set)
    executed: set[int] = field(default_factory=set)

    @property
    def missed(self) -> list[int]:
        """Return the lines that no simulation executed, in their order."""
        return sorted(self.lines - self.executed)


def _inside(path: Path, folder: Path) -> bool:
    return folder in path.parents


def read_results(folder: Path, sources: Path) -> dict[Path, FileLines]:
    """Add up all JSON files in ``folder``, for the VHDL files below ``sources``.

    Raises ValueError, which names the file, for an incomplete file.
    """
    found: dict[Path, FileLines] = {}
    for result in sorted(folder.glob("*.json")):
        try:
            outputs = json.loads(result.read_text(encoding="utf-8"))["outputs"]
            entries = [
                (Path(entry["dir"], entry["file"]).resolve(), entry["mode"], entry["result"])
                for entry in outputs
            ]
        except (ValueError, KeyError, TypeError) as error:
            raise ValueError(f"{result}: not a whole result of GHDL ({error})") from error
        for path, mode, lines in entries:
            if mode != "stmt" or not _inside(path, sources):
                continue
            of_file = found.setdefault(path, FileLines())
            of_file.lines |= {int(line) for line in lines}
            of_file.executed |= {int(line) for line, times in lines.items() if times}
    return found


def has_body(path: Path) -> bool:
    """Tell whether a VHDL file describes hardware; a package of constants does not."""
    text = path.read_text(encoding="utf-8").lower()
    return "architecture " in text or "package body" in text


def has_statements(path: Path) -> bool:
    """Tell whether GHDL counts lines of a VHDL file; it counts no lines in an entity that only
    instantiates other entities."""
    text = re.sub(r"--[^\n]*", "", path.read_text(encoding="utf-8").lower())
    if "package body" in text:
        return True
    _, _, body = text.partition("architecture ")
    _, _, statements = body.partition("\nbegin")
    return bool(re.search(r"<=|\bprocess\b|\bassert\b", statements))


def share(found: dict[Path, FileLines]) -> float:
    """Return the number of executed lines divided by the number of lines with statements; 0 if
    there are no lines."""
    lines = sum(len(entry.lines) for entry in found.values())
    return sum(len(entry.executed) for entry in found.values()) / lines if lines else 0.0


def faults(found: dict[Path, FileLines], sources: Path, budget: float = BUDGET) -> list[str]:
    """Return a sentence for each file with statements that is in no simulation, and one if the
    share is below the budget."""
    messages = [
        f"{path.relative_to(sources.parent)} was in no simulation"
        for path in sorted(sources.rglob("*.vhd"))
        if path not in found and has_statements(path)
    ]
    reached = share(found)
    if reached < budget:
        messages.append(
            f"the benches execute {reached:.1%} of the statements, expected {budget:.0%} at least"
        )
    return messages


def table(found: dict[Path, FileLines], root: Path) -> str:
    """Return Markdown with a row for each file: number of lines with statements, number of executed
    lines, and the missed lines."""
    lines = [
        "| file | lines with statements | executed | share | not executed |",
        "|---|---:|---:|---:|---|",
    ]
    for path, entry in sorted(found.items()):
        part = len(entry.executed) / len(entry.lines) if entry.lines else 1.0
        missed = ", ".join(str(line) for line in entry.missed)
        lines.append(
            f"| {path.relative_to(root)} | {len(entry.lines)} | {len(entry.executed)} "
            f"| {part:.1%} | {missed} |"
        )
    total = sum(len(entry.lines) for entry in found.values())
    executed = sum(len(entry.executed) for entry in found.values())
    lines.append(f"| **all** | {total} | {executed} | {share(found):.1%} | |")
    return "\n".join(lines) + "\n"


def run_benches(tests: Sequence[str], folder: Path, workers: int) -> int:
    """Run the benches while GHDL counts lines; return the exit code of pytest. Raises ToolError."""
    command, _ = find_ghdl()
    ghdl = shutil.which(command)
    if ghdl is None or Path(ghdl).name != "ghdl":
        raise ToolError(f"{command}: cocotb starts a program of the name ghdl; give it this name")
    places = os.pathsep.join([str(Path(ghdl).resolve().parent), os.environ.get("PATH", "")])
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-n", str(workers), *tests],
        cwd=ROOT,
        env={**os.environ, "PATH": places, VARIABLE: str(folder)},
        check=False,
        timeout=RUN_LIMIT_S,
    )
    return done.returncode


def main(arguments: list[str] | None = None) -> int:
    """Run the benches and write the coverage; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "tests",
        nargs="*",
        default=BENCHES,
        help="arguments of pytest (tb without the longest benches)",
    )
    parser.add_argument("--workers", type=int, default=2, help="processes of pytest (2)")
    parser.add_argument("--add", action="store_true", help="keep earlier results and add to them")
    parser.add_argument("--read", action="store_true", help="only add up earlier results")
    chosen = parser.parse_args(arguments)
    failed = 0
    try:
        if not chosen.read:
            if not chosen.add:
                shutil.rmtree(FOLDER, ignore_errors=True)
            FOLDER.mkdir(parents=True, exist_ok=True)
            failed = run_benches(chosen.tests, FOLDER, chosen.workers)
        found = read_results(FOLDER, ROOT / "rtl")
    except (ToolError, ValueError, subprocess.TimeoutExpired) as error:
        print(f"coverage: {error}", file=sys.stderr)
        return 2
    text = table(found, ROOT)
    FOLDER.mkdir(parents=True, exist_ok=True)
    (FOLDER / "coverage.md").write_text(text, encoding="utf-8")
    print(text)
    messages = faults(found, ROOT / "rtl")
    if failed:
        messages.append("a bench failed")
    for fault in messages:
        print(f"coverage: {fault}", file=sys.stderr)
    return 1 if messages else 0


if __name__ == "__main__":
    raise SystemExit(main())
