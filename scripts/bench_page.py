"""All benches as one page: ``python -m scripts.bench_page FILE``, what ``make bench`` does.

Machine, versions and commit, then what each bench prints, each row beside its limit or peer. A
bench that fails is on the page with its message; the exit code is 1 then.
"""

from __future__ import annotations

import importlib.metadata
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path

from arctrue.whole_file import write_whole_text

ROOT = Path(__file__).resolve().parents[1]
BENCHES: Mapping[str, tuple[str, str]] = {
    "scripts.bench_calibration": (
        "Calibration and gateware",
        "The error of a calibration beside the Cramér–Rao bound and beside numpy's FFT used "
        "plainly; the bit-true gateware beside equation (8) in float64.",
    ),
    "scripts.bench_firmware": (
        "Firmware",
        "Instructions of one calibration on the Cortex-A9, counted in QEMU, beside a plain "
        "implementation on the same processor and numpy on this machine; goals in milliseconds.",
    ),
    "scripts.bench_instrument": (
        "Virtual instrument",
        "Clocks a second of the compiled netlist beside GHDL's two code generators.",
    ),
    "scripts.bench_campaign": (
        "Campaigns",
        "Tasks of a campaign beside the same work in plain processes.",
    ),
    "scripts.bench_workbench": (
        "Workbench",
        "Time and memory of compare and diagnose against the rows of a set, beside their limits.",
    ),
}
PACKAGES = ("arctrue", "numpy", "scipy", "pyarrow")
TOOLS = {"ghdl": "--version", "verilator": "--version", "qemu-system-arm": "--version"}


def machine() -> list[tuple[str, str]]:
    """What the figures depend on: name and value."""
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


def page(facts: Sequence[tuple[str, str]], outputs: Mapping[str, tuple[int, str]]) -> str:
    """Markdown; ``outputs``: exit code and text of every bench that was run."""
    lines = ["# Benches", "", "Made by `make bench`.", "", "| | |", "|---|---|"]
    lines += [f"| {name} | {value} |" for name, value in facts]
    for module, (code, text) in outputs.items():
        title, about = BENCHES[module]
        verdict = "" if code == 0 else f"**Exit code {code}: a limit is missed, or it failed.** "
        lines += ["", f"## {title}", "", f"{verdict}{about} `python -m {module}`", "", "```text"]
        lines += [text.rstrip("\n"), "```"]
    return "\n".join(lines) + "\n"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run every bench, showing what it prints, and write the page."""
    words = sys.argv[1:] if arguments is None else arguments
    if len(words) != 1:
        print("expected one argument: the page to write, such as build/bench/page.md")
        return 2
    facts = machine()
    outputs = {}
    for module in BENCHES:
        print(f"\n== {BENCHES[module][0]}", flush=True)
        done = subprocess.run(
            [sys.executable, "-m", module], cwd=ROOT, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, text=True, check=False,
        )  # fmt: skip
        print(done.stdout, end="", flush=True)
        outputs[module] = (done.returncode, done.stdout)
    file = Path(words[0])
    write_whole_text(file, page(facts, outputs))
    print(f"\nwrote {file}")
    return int(any(code for code, _ in outputs.values()))


def _first_line(command: Sequence[str]) -> str:
    if shutil.which(command[0]) is None:
        return "not there"
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return (done.stdout or done.stderr).splitlines()[0] if done.returncode == 0 else "not there"


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


if __name__ == "__main__":
    raise SystemExit(main())
