"""Measures which lines of the firmware's C the host tests run, and fails below 90 %.

``python -m scripts.firmware_coverage`` (``make coverage-firmware``) makes the host build of
sim/tests/firmware with gcc's ``--coverage``, runs the tests of the firmware and of the boot images
once, and reads gcov's counts. Code that needs the processor (firmware/board) is not included. The
script prints a line for each file and writes every line that was not run to
build/firmware/coverage/lines.txt.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).resolve().parents[1]
BUILT: Final = ROOT / "build" / "firmware" / "coverage"
FIRMWARE: Final = ROOT / "firmware"
TESTS: Final = (ROOT / "sim" / "tests" / "firmware", ROOT / "scripts" / "tests" / "image")
OTHER_BUILDS: Final = (
    "test_qemu.py",
    "test_qemu_device.py",
    "test_sanitizers.py",
    "test_fuzz_corpus.py",
)
"""Tests that are left out, because they need the image or other builds of the firmware."""
LEAST: Final = 0.9
TESTS_TIMEOUT_S: Final = 1800
GCOV_TIMEOUT_S: Final = 120

Counts = dict[str, dict[int, int]]
"""Number of executions of each line, by file below firmware/ and line number."""


def run_tests() -> None:
    """Run the host tests. Raises RuntimeError if a test fails."""
    shutil.rmtree(BUILT, ignore_errors=True)
    BUILT.mkdir(parents=True)
    files = [
        str(path)
        for folder in TESTS
        for path in sorted(folder.glob("test_*.py"))
        if path.name not in OTHER_BUILDS
    ]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *files],
        cwd=ROOT,
        env={**os.environ, "ARCTRUE_COVERAGE": str(BUILT)},
        capture_output=True,
        text=True,
        check=False,
        timeout=TESTS_TIMEOUT_S,
    )
    if done.returncode:
        raise RuntimeError(f"the host tests fail:\n{done.stdout[-2000:]}")


def counted(answers: list[str]) -> Counts:
    """Return gcov's counts of the files below firmware/; if a line has several counts, the
    largest."""
    found: Counts = defaultdict(dict)
    for answer in answers:
        for entry in json.loads(answer)["files"]:
            path = Path(entry["file"])
            if not path.is_relative_to(FIRMWARE):
                continue
            lines = found[str(path.relative_to(FIRMWARE))]
            for line in entry["lines"]:
                number = line["line_number"]
                lines[number] = max(lines.get(number, 0), line["count"])
    return dict(found)


def read_counts() -> Counts:
    """Return the counts from all objects of the host build. Raises RuntimeError if gcov fails."""
    answers = []
    for data in sorted(BUILT.glob("*.gcda")):
        done = subprocess.run(
            ["gcov", "--json-format", "--stdout", str(data)],
            cwd=BUILT,
            capture_output=True,
            text=True,
            check=False,
            timeout=GCOV_TIMEOUT_S,
        )
        if done.returncode:
            raise RuntimeError(f"gcov fails on {data.name}: {done.stderr.strip()}")
        answers += done.stdout.splitlines()
    return counted(answers)


def share(lines: dict[int, int]) -> float:
    """Return the share of the lines with code that were executed."""
    return sum(count > 0 for count in lines.values()) / len(lines) if lines else 1.0


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the tests and print the coverage of each file; return the exit code, 1 if a test or gcov
    fails or the share of executed lines is too small."""
    argparse.ArgumentParser(description=__doc__).parse_args(arguments)
    try:
        run_tests()
        counts = read_counts()
    except (RuntimeError, subprocess.TimeoutExpired) as error:
        print(error, file=sys.stderr)
        return 1
    missed = []
    for name, lines in sorted(counts.items(), key=lambda item: share(item[1])):
        print(f"{share(lines):7.1%}  {len(lines):5}  {name}")
        missed += [f"{name}:{line}" for line, count in sorted(lines.items()) if not count]
    (BUILT / "lines.txt").write_text("\n".join(missed) + "\n", encoding="utf-8")
    every = {(name, line): count for name, lines in counts.items() for line, count in lines.items()}
    total = sum(count > 0 for count in every.values()) / max(len(every), 1)
    print(f"{total:7.1%}  {len(every):5}  in all, at least {LEAST:.0%} wanted")
    return 0 if total >= LEAST else 1


if __name__ == "__main__":
    sys.exit(main())
