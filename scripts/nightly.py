"""Runs the long checks of one commit and writes docs/nightly.md: ``python -m scripts.nightly``.

``make nightly`` runs all checks one after the other; ``--only NAME`` runs the named checks. A check
is skipped if the same part of the check has already ended for this commit, so that a second run
continues an interrupted one (``--again`` repeats such checks). ``--sample`` runs, for a check that
defines a sample, only this sample; each row of the page states which part ran, on which commit, and
how it ended. Uncommitted changes are refused, because a figure must belong to a commit. Exit code
1: a check failed. 2: the tree differs from its commit, or the record of earlier runs is damaged.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from pathlib import Path

from arctrue.base.typed_content import ContentError, read_json
from arctrue.base.whole_file import write_whole_text

ROOT = Path(__file__).resolve().parents[1]
RECORD = ROOT / "docs/data/nightly.json"
PAGE = ROOT / "docs/nightly.md"
LOGS = ROOT / "build/nightly"
WRITTEN_BY_CHECKS = (
    "docs/nightly.md",
    "docs/data/nightly.json",
    "docs/proofs.md",
    "docs/systems.md",
)
"""Files that a check may change; all other files of the tree must equal the commit."""


@dataclass(frozen=True)
class Check:
    """Long check: its command, the statement that its success proves, and a shorter sample for a
    small machine."""

    name: str
    command: tuple[str, ...]
    shows: str
    sample: tuple[str, ...] = ()
    sample_is: str = ""


@dataclass(frozen=True)
class Outcome:
    """Result of one run of a check; ``part`` is empty if the whole check ran."""

    name: str
    commit: str
    day: str
    part: str
    passed: bool
    minutes: float
    last_line: str


CHECKS = (
    Check("test", ("make", "test"), "all checks and tests pass, except those of make test-large"),
    Check(
        "test-large",
        ("make", "test-large"),
        "the tests of larger configurations and of further cases pass",
    ),
    Check(
        "demo",
        ("make", "demo"),
        "the device calibrates and corrects; a hidden effect is named and corrected",
    ),
    Check(
        "systems",
        ("scripts/try_systems.sh", "--page", "docs/systems.md"),
        "both README commands and `pip install` work on Debian 12, Debian 13, Ubuntu 24.04",
        ("scripts/try_systems.sh", "--page", "docs/systems.md", "debian13"),
        "Debian 13 only",
    ),
    Check("formal", ("make", "formal"), "each proof holds, and fails on broken VHDL"),
    Check("synth", ("make", "synth"), "resources of every unit and fold are within their budgets"),
    Check(
        "mutate",
        ("make", "mutate"),
        "a test fails for each fault put into VHDL, C and the guards of the diagnosis",
        ("make", "mutate", "MUTATIONS=--every 6"),
        "every sixth mutation of the list",
    ),
    Check(
        "coverage-gateware",
        ("make", "coverage-gateware"),
        "the benches execute the budgeted share of the statements of rtl/",
    ),
    Check(
        "coverage-firmware",
        ("make", "coverage-firmware"),
        "the host tests execute at least 90 % of the lines of the firmware",
    ),
    Check(
        "bench",
        ("make", "bench"),
        "calibration, firmware and workbench keep their limits",
    ),
    Check(
        "bitstream",
        ("make", "bitstream", "FLOW=open"),
        "the open flow makes a bitstream of the default core",
    ),
    Check(
        "verify-bitstream",
        ("make", "verify-bitstream"),
        "the decoded bitstream behaves clock by clock like the VHDL",
    ),
)


def read_outcomes(path: Path) -> dict[str, Outcome]:
    """Return the outcomes in a record file, by the name of the check; an empty mapping if there is
    no file.

    Raises ContentError, which names the file and the key, for wrong content.
    """
    if not path.exists():
        return {}
    rows = read_json(path, list[Outcome])
    return {row.name: row for row in rows}


def commit_of(root: Path) -> str:
    """Return the short hash of the commit in ``root``.

    Raises RuntimeError if files differ from the commit, except those in WRITTEN_BY_CHECKS.
    """
    command = ("git", "status", "--porcelain", "--untracked-files=no")
    changed = subprocess.run(command, cwd=root, capture_output=True, text=True, check=True)
    files = [line[3:] for line in changed.stdout.splitlines()]
    others = [file for file in files if file not in WRITTEN_BY_CHECKS]
    if others:
        raise RuntimeError(
            f"{len(others)} files differ from the commit, the first is {others[0]}: commit or undo "
            "the changes, because each figure of the page belongs to a commit"
        )
    command = ("git", "rev-parse", "--short=9", "HEAD")
    return subprocess.run(
        command, cwd=root, capture_output=True, text=True, check=True
    ).stdout.strip()


def run(check: Check, *, sample: bool, commit: str, root: Path, logs: Path) -> Outcome:
    """Run one check and write its output into ``logs``; the outcome keeps the last line of the
    output, with paths relative to ``root``."""
    part = check.sample_is if sample else ""
    command = check.sample if part else check.command
    logs.mkdir(parents=True, exist_ok=True)
    log = logs / f"{check.name}.txt"
    start = time.monotonic()
    with log.open("w", encoding="utf-8") as stream:
        done = subprocess.run(
            command, cwd=root, stdout=stream, stderr=subprocess.STDOUT, check=False
        )
    minutes = (time.monotonic() - start) / 60
    text = log.read_text(encoding="utf-8", errors="replace")
    last = next((line for line in reversed(text.splitlines()) if line.strip()), "(no output)")
    return Outcome(
        name=check.name,
        commit=commit,
        day=datetime.now(UTC).strftime("%Y-%m-%d"),
        part=part,
        passed=done.returncode == 0,
        minutes=round(minutes, 1),
        last_line=last.replace(f"{root}/", "").strip().strip("= ")[:140],
    )


def page(outcomes: Mapping[str, Outcome]) -> str:
    """Return the page with a row for each check; the row of a check without an outcome states *not
    run*."""
    lines = [
        "<!-- Made by scripts/nightly.py. Do not edit: make nightly -->",
        "",
        "# Long checks",
        "",
        "`make nightly` runs these checks and writes this page. A row belongs to the commit that "
        "it names. *Part* states what ran if the whole check takes too long for the machine.",
        "",
        "| Check | Shows | Part | Result | Minutes | Commit, day |",
        "|---|---|---|---|---:|---|",
    ]
    for check in CHECKS:
        outcome = outcomes.get(check.name)
        name = f"`{' '.join(check.command)}`"
        if outcome is None:
            lines.append(f"| {name} | {check.shows} | | not run | | |")
            continue
        result = "passed" if outcome.passed else "**failed**"
        last = outcome.last_line.replace("|", "\\|")
        lines.append(
            f"| {name} | {check.shows} | {outcome.part or 'whole'} | {result}: {last} | "
            f"{outcome.minutes:.0f} | {outcome.commit}, {outcome.day} |"
        )
    return "\n".join(lines) + "\n"


def keep(outcomes: Mapping[str, Outcome]) -> None:
    """Write the record and the page; both list the outcomes in the order of CHECKS."""
    rows = [asdict(outcomes[check.name]) for check in CHECKS if check.name in outcomes]
    write_whole_text(RECORD, json.dumps(rows, indent=1, ensure_ascii=False) + "\n")
    write_whole_text(PAGE, page(outcomes))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the checks that the command line names, or all checks; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    names = [check.name for check in CHECKS]
    parser.add_argument(
        "--only",
        nargs="+",
        choices=names,
        default=names,
        metavar="NAME",
        help=f"run these checks: {', '.join(names)}",
    )
    parser.add_argument("--sample", action="store_true", help="run only a check's sample")
    parser.add_argument("--again", action="store_true", help="also run checks that have ended")
    options = parser.parse_args(arguments)
    try:
        commit = commit_of(ROOT)
        outcomes = read_outcomes(RECORD)
    except (RuntimeError, ContentError) as fault:
        print(f"nightly: {fault}", file=sys.stderr)
        return 2
    for check in CHECKS:
        if check.name not in options.only:
            continue
        before = outcomes.get(check.name)
        part = check.sample_is if options.sample else ""
        ended = before is not None and (before.commit, before.part) == (commit, part)
        if ended and not options.again:
            continue
        print(f"{check.name}: {' '.join(check.sample if part else check.command)}", flush=True)
        outcome = run(check, sample=options.sample, commit=commit, root=ROOT, logs=LOGS)
        outcomes[check.name] = outcome
        keep(outcomes)
        print(
            f"  {'passed' if outcome.passed else 'FAILED'} after {outcome.minutes:.0f} min: "
            f"{outcome.last_line} ({LOGS.relative_to(ROOT)}/{check.name}.txt)",
            flush=True,
        )
    run_now = [outcomes[name] for name in options.only if name in outcomes]
    return 0 if all(outcome.passed for outcome in run_now) else 1


if __name__ == "__main__":
    sys.exit(main())
