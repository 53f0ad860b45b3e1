"""Tests how a run of the long checks is recorded, shown and resumed."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from scripts import nightly
from scripts.nightly import CHECKS, Check, Outcome, commit_of, page, read_outcomes, run

ROOT = Path(__file__).resolve().parents[3]


def repository(folder: Path) -> Path:
    """Return a repository that has one commit with one file."""
    (folder / "file.txt").write_text("first\n", encoding="utf-8")
    for words in (
        ("init", "-q"),
        ("add", "file.txt"),
        ("-c", "user.name=a", "-c", "user.email=a@b", "commit", "-q", "-m", "one"),
    ):
        subprocess.run(("git", *words), cwd=folder, check=True)
    return folder


def test_a_check_keeps_exit_code_and_last_line(tmp_path: Path) -> None:
    """The outcome of a check keeps exit code and last line; the shell commands in the test
    determine both."""
    good = Check("good", ("sh", "-c", "echo first; echo '== 3 passed =='; echo"), "")
    bad = Check("bad", ("sh", "-c", "echo broken >&2; exit 3"), "")
    outcome = run(good, sample=False, commit="abc", root=tmp_path, logs=tmp_path / "logs")
    assert (outcome.passed, outcome.last_line, outcome.part) == (True, "3 passed", "")
    outcome = run(bad, sample=False, commit="abc", root=tmp_path, logs=tmp_path / "logs")
    assert (outcome.passed, outcome.last_line) == (False, "broken")


def test_the_page_has_no_path_of_the_machine(tmp_path: Path) -> None:
    """The last line names a file in the tree by its path from the root of the tree."""
    check = Check("demo", ("sh", "-c", "echo Page: $PWD/build/page.html"), "")
    outcome = run(check, sample=False, commit="abc", root=tmp_path, logs=tmp_path)
    assert outcome.last_line == "Page: build/page.html"


def test_a_sample_is_run_and_named(tmp_path: Path) -> None:
    check = Check("one", ("sh", "-c", "echo all"), "", ("sh", "-c", "echo part"), "a sixth")
    outcome = run(check, sample=True, commit="abc", root=tmp_path, logs=tmp_path)
    assert (outcome.last_line, outcome.part) == ("part", "a sixth")


def test_changes_without_a_commit_are_refused(tmp_path: Path) -> None:
    folder = repository(tmp_path)
    assert len(commit_of(folder)) == 9
    (folder / "file.txt").write_text("second\n", encoding="utf-8")
    with pytest.raises(RuntimeError, match=r"the first is file\.txt"):
        commit_of(folder)


def test_an_ended_check_is_not_run_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A check that has ended is not run again: each run adds one line to a file, and the second
    call must add no line. A failed check returns 1."""
    folder = repository(tmp_path)
    runs = folder / "runs"
    once = Check("once", ("sh", "-c", f"echo run >> {runs}; exit 1"), "")
    monkeypatch.setattr(nightly, "ROOT", folder)
    monkeypatch.setattr(nightly, "CHECKS", (once,))
    monkeypatch.setattr(nightly, "RECORD", folder / "docs/data/nightly.json")
    monkeypatch.setattr(nightly, "PAGE", folder / "docs/nightly.md")
    monkeypatch.setattr(nightly, "LOGS", folder / "logs")
    (folder / "docs/data").mkdir(parents=True)
    assert nightly.main(["--only", "once"]) == 1
    assert nightly.main(["--only", "once"]) == 1
    assert runs.read_text(encoding="utf-8").count("run") == 1
    assert nightly.main(["--again"]) == 1
    assert runs.read_text(encoding="utf-8").count("run") == 2


def test_the_page_belongs_to_its_record() -> None:
    """The page in the tree equals the page that the program makes from the record in the tree, with
    a row for each check."""
    outcomes = read_outcomes(nightly.RECORD)
    text = page(outcomes)
    assert text == nightly.PAGE.read_text(encoding="utf-8")
    assert text.count("\n| `") == len(CHECKS)
    assert text.count("| not run |") == len(CHECKS) - len(outcomes)


def test_a_sample_and_a_failure_are_shown() -> None:
    outcome = Outcome("mutate", "abc", "2026-11-23", "every sixth", False, 12.3, "29 of 30")
    row = next(line for line in page({"mutate": outcome}).splitlines() if "mutate" in line)
    assert "| every sixth | **failed**: 29 of 30 | 12 | abc, 2026-11-23 |" in row


def test_each_command_is_a_target_of_the_makefile() -> None:
    """The command of each check is a target of the Makefile or a file of the tree, so that a reader
    can repeat the check."""
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    for check in CHECKS:
        for command in filter(None, (check.command, check.sample)):
            if command[0] == "make":
                assert f"\n{command[1]}:" in makefile
            else:
                assert (ROOT / command[0]).exists()
