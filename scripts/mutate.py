"""Applies one mutation (a deliberate error) at a time to VHDL, C or the diagnosis, and checks that
the named test fails.

``make mutate`` runs all mutations, ``python -m scripts.mutate NAME ...`` some of them; ``--every
6`` runs every sixth mutation of the list. The script works in a copy of the tree. Exit code 1: a
mutation survives. 2: the list does not fit the tree, a test fails without a mutation, or no test
ran on a mutated file.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from scripts.firmware_mutations import FIRMWARE_MUTATIONS
from scripts.mutation import Mutation
from scripts.mutations import VHDL_MUTATIONS
from scripts.mutations_of_guards import GUARD_MUTATIONS

MUTATIONS = (*VHDL_MUTATIONS, *FIRMWARE_MUTATIONS, *GUARD_MUTATIONS)

ROOT = Path(__file__).resolve().parents[1]
COPIED = (
    "rtl",
    "tb",
    "sim",
    "scripts",
    "firmware",
    "build/generated",
    "pyproject.toml",
    "conftest.py",
)
GHDL_OF_NETLISTS = ROOT / "build/ghdl5/bin/ghdl"
"""Path of the GHDL that scripts/install_ghdl_netlist.sh unpacks; the copy of the tree does not
contain it."""
TIMEOUT_S = 600
BUILD_FAILED = ("in _built", "the firmware does not compile")
"""Texts in pytest's output that show a failed build: the name of a function of tb/support, and a
message of the firmware build."""


def faults_of_list(root: Path, mutations: tuple[Mutation, ...]) -> list[str]:
    """Return a sentence for each fault of the list: an old text that does not occur exactly once or
    equals the new text, a missing test, and a name that occurs twice."""
    faults: list[str] = []
    for mutation in mutations:
        path = root / mutation.file
        found = path.read_text(encoding="utf-8").count(mutation.old) if path.exists() else 0
        if found != 1:
            faults.append(
                f"{mutation.name}: {mutation.file} contains the old text {found} times, expected 1"
            )
        if mutation.old == mutation.new:
            faults.append(f"{mutation.name}: old and new text are the same")
        file, _, function = mutation.test.partition("::")
        test = root / file
        if not test.exists():
            faults.append(f"{mutation.name}: there is no {file}")
        elif function and f"def {function.split('[')[0]}(" not in test.read_text(encoding="utf-8"):
            faults.append(f"{mutation.name}: {file} has no {function}")
    names = [mutation.name for mutation in mutations]
    faults += [
        f"{name}: two mutations of this name" for name in set(names) if names.count(name) > 1
    ]
    return faults


def copy_tree(root: Path, copy: Path) -> None:
    """Copy the files of the tree that the tests need."""
    for name in COPIED:
        source = root / name
        if source.is_dir():
            shutil.copytree(source, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
        elif source.exists():
            shutil.copy2(source, copy / name)


def run_test(copy: Path, test: str) -> tuple[int, str]:
    """Run pytest once in the copy; return exit code and output. A test that hangs counts as
    failed."""
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-x",
        "--tb=native",
        "-p",
        "no:cacheprovider",
        test,
    ]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(copy), str(copy / "sim")])}
    if GHDL_OF_NETLISTS.exists():
        environment.setdefault("GHDL_NETLIST", str(GHDL_OF_NETLISTS))
    try:
        done = subprocess.run(
            command, cwd=copy, env=environment, capture_output=True, text=True, timeout=TIMEOUT_S
        )
    except subprocess.TimeoutExpired:
        return 1, f"not finished after {TIMEOUT_S} s"
    return done.returncode, done.stdout + done.stderr


def say(words: str) -> None:
    """Print a line and flush it, so that a long run shows its progress."""
    print(words, flush=True)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the mutations that the command line names, or all mutations; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="run these mutations alone", metavar="NAME")
    parser.add_argument(
        "--every", type=int, default=1, metavar="K", help="run each K-th mutation of the list"
    )
    options = parser.parse_args(arguments)
    names = options.names
    if options.every < 1:
        parser.error(f"--every {options.every}: expected 1 or more")
    unknown = sorted(set(names) - {mutation.name for mutation in MUTATIONS})
    chosen = [one for one in MUTATIONS if not names or one.name in names]
    mutations = tuple(chosen[:: options.every])
    faults = [f"{name}: no mutation of this name" for name in unknown]
    faults += faults_of_list(ROOT, mutations)
    if faults:
        print("\n".join(faults), file=sys.stderr)
        return 2
    survived: list[str] = []
    with tempfile.TemporaryDirectory(prefix="arctrue-mutate-") as folder:
        copy = Path(folder)
        copy_tree(ROOT, copy)
        tests = sorted({mutation.test for mutation in mutations})
        say(f"{len(tests)} tests without a mutation must pass")
        for test in tests:
            code, output = run_test(copy, test)
            if code:
                print(output, file=sys.stderr)
                print(f"{test}: fails without any mutation", file=sys.stderr)
                return 2
        say(f"{len(mutations)} mutations")
        for mutation in mutations:
            path = copy / mutation.file
            text = path.read_text(encoding="utf-8")
            start = time.monotonic()
            path.write_text(text.replace(mutation.old, mutation.new), encoding="utf-8")
            code, output = run_test(copy, mutation.test)
            path.write_text(text, encoding="utf-8")
            # If GHDL rejects a mutation, or the test cannot start, the failure does not show that
            # the test detects the error.
            if code not in (0, 1) or (code and any(text in output for text in BUILD_FAILED)):
                print(output, file=sys.stderr)
                print(f"{mutation.name}: no test ran on the mutated file", file=sys.stderr)
                return 2
            result = "caught" if code else "SURVIVED"
            say(
                f"  {result:9} {time.monotonic() - start:5.0f} s  {mutation.name}: {mutation.fault}"
            )
            if not code:
                survived.append(f"{mutation.name} in {mutation.file}; {mutation.test} should fail")
    for line in survived:
        print(f"survived: {line}", file=sys.stderr)
    say(f"{len(mutations) - len(survived)} of {len(mutations)} mutations caught")
    return 1 if survived else 0


if __name__ == "__main__":
    sys.exit(main())
