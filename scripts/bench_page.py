"""Runs all benches and writes one page with their results: ``python -m scripts.bench_page FILE``
(``make bench``).

The page shows machine, versions and commit, then the rows of each bench: median, quartiles and
extremes of its runs, and the limit or the value of another program (the peer). For a failed bench
it shows the last lines of output; the exit code is then 1. ``--only NAME`` repeats one bench; the
rows of the other benches are read from the files next to the page, each with the commit and load of
its own run.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import json
import os
import platform
import shutil
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path

from arctrue.base.typed_content import read_json
from arctrue.base.whole_file import write_whole_text
from scripts.bench_rows import Row, read_rows, table

ROOT = Path(__file__).resolve().parents[1]
BENCH_S = 4 * 3600
"""Time limit of a bench. The longest bench takes half an hour on an idle machine."""
BENCHES: Mapping[str, tuple[str, str]] = {
    "scripts.bench_calibration": (
        "Calibration and gateware",
        "The error of a calibration, the Cramér–Rao bound and numpy's plain FFT; "
        "the bit-true gateware and equation (8) in float64.",
    ),
    "scripts.bench_firmware": (
        "Firmware",
        "Instructions of one calibration on the Cortex-A9, counted in QEMU, compared with a plain "
        "implementation on the same processor and with numpy on this machine. Milliseconds "
        "of the ARM assume 1 to 2 cycles per instruction.",
    ),
    "scripts.bench_instrument": (
        "Virtual instrument",
        "Clocks per second of the compiled netlist and of GHDL's two code generators.",
    ),
    "scripts.bench_parts": (
        "Parts",
        "Processor time of the gateware's models, of the search for lines, of the import and of "
        "the device's daemon, with their limits.",
    ),
    "scripts.bench_campaign": (
        "Campaigns",
        "The processor time of a campaign's processes, compared with the work alone.",
    ),
    "scripts.bench_workbench": (
        "Workbench",
        "Time and memory of compare and diagnose by rows of a set, with their limits.",
    ),
}
PACKAGES = ("arctrue", "numpy", "scipy", "pyarrow")
TOOLS = {"ghdl": "--version", "verilator": "--version", "qemu-system-arm": "--version"}


def machine() -> list[tuple[str, str]]:
    """Return name and value of the facts on which the figures depend: machine, versions, commit."""
    facts = [
        ("date", datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")),
        ("commit", _first_line(["git", "-C", str(ROOT), "describe", "--always", "--dirty"])),
        ("processor", f"{_processor()}, {os.cpu_count()} cores"),
        ("system", platform.platform()),
        ("load before", ", ".join(f"{value:.1f}" for value in os.getloadavg())),
        ("Python", platform.python_version()),
    ]
    facts += [(name, importlib.metadata.version(name)) for name in PACKAGES]
    facts += [(tool, _first_line([tool, option])) for tool, option in TOOLS.items()]
    return facts


@dataclass(frozen=True, slots=True)
class Ran:
    """Result of one run of a bench."""

    code: int
    rows: tuple[Row, ...]
    text: str
    """Output of the bench."""
    facts: Mapping[str, str]
    """Date, commit, load before and after, duration, and options, if there are any."""


def page(facts: Sequence[tuple[str, str]], benches: Mapping[str, Ran]) -> str:
    """Return the page in Markdown; ``benches``: the results of every bench that ran."""
    lines = ["# Benches", "", f"Made by `make bench`. {READING}", "", "| | |", "|---|---|"]
    lines += [f"| {name} | {value} |" for name, value in facts]
    for module, ran in benches.items():
        title, about = BENCHES[module]
        figures_line = "; ".join(f"{name} {value}" for name, value in ran.facts.items())
        lines += ["", f"## {title}", "", f"{about} `python -m {module}` ({figures_line}).", ""]
        if ran.code:
            lines += [f"**Exit code {ran.code}: a limit is missed, or the bench failed.**", ""]
        if ran.rows:
            lines += table(ran.rows)
        else:
            lines += ["```text", *ran.text.rstrip("\n").splitlines()[-LAST_WORDS:], "```"]
    return "\n".join(lines) + "\n"


READING = (
    "*Median*, *quartiles* and *least to most* are those of the runs; a *counted* figure is always "
    "the same. Times are processor times wherever possible. Other work on the "
    "machine still affects them by caches and clock rate; the page states the load."
)
LAST_WORDS = 20


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benches, print their output, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path, help="the page to write, such as build/bench/page.md")
    parser.add_argument(
        "--only",
        choices=[module.partition("bench_")[2] for module in BENCHES],
        action="append",
        help="run this benchmark alone; may be repeated",
    )
    parser.add_argument(
        "--most-rows", help="leave out sets of the workbench with more rows: they take hours"
    )
    given = parser.parse_args(arguments)
    options = {"scripts.bench_workbench": ["--most-rows", given.most_rows]}
    folder: Path = given.file.parent / "rows"
    folder.mkdir(parents=True, exist_ok=True)
    facts = machine()
    benches = {}
    for module in BENCHES:
        name = module.partition("bench_")[2]
        stored = folder / f"{name}.ran.json"
        if given.only is None or name in given.only:
            print(f"\n== {BENCHES[module][0]}", flush=True)
            words = options.get(module, []) if given.most_rows else []
            benches[module] = run(module, folder / f"{name}.json", words)
            write_whole_text(stored, json.dumps(asdict(benches[module]), indent=1) + "\n")
        elif stored.exists():
            benches[module] = read_json(stored, Ran)
    write_whole_text(given.file, page(facts, benches))
    print(f"\nwrote {given.file}")
    return int(any(ran.code for ran in benches.values()))


def run(module: str, rows: Path, options: Sequence[str] = ()) -> Ran:
    """Run one bench until it ends, or for at most ``BENCH_S``."""
    rows.unlink(missing_ok=True)
    facts = {
        "begun": datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        "commit": _first_line(["git", "-C", str(ROOT), "describe", "--always", "--dirty"]),
        "load before": _load(),
    }
    begun = time.monotonic()
    command = [sys.executable, "-m", module, "--rows", str(rows), *options]
    if options:
        facts["options"] = f"`{' '.join(options)}`"
    try:
        done = subprocess.run(
            command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            check=False, timeout=BENCH_S,
        )  # fmt: skip
        code, text = done.returncode, done.stdout
    except subprocess.TimeoutExpired:
        code, text = 1, f"not finished after {BENCH_S} s"
    print(text, end="", flush=True)
    facts["load after"] = _load()
    facts["minutes"] = f"{(time.monotonic() - begun) / 60:.1f}"
    return Ran(code, tuple(read_rows(rows)) if rows.exists() else (), text, facts)


def _load() -> str:
    return f"{os.getloadavg()[0]:.1f}"


def _first_line(command: Sequence[str]) -> str:
    if shutil.which(command[0]) is None:
        return "missing"
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return (done.stdout or done.stderr).splitlines()[0] if done.returncode == 0 else "missing"


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


if __name__ == "__main__":
    raise SystemExit(main())
