"""Tests that pages that show commands also show the real output of these commands."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from sim.tests.workbench.page_commands import (
    Command,
    FileToWrite,
    assert_shown,
    run,
    same,
    steps,
)

DOCS = Path(__file__).resolve().parents[3] / "docs"


def _follow(page: Path) -> int:
    """Run all commands of a page and write all files of the page in the working folder; return the
    number of commands."""
    commands = 0
    for step in steps(page):
        if isinstance(step, FileToWrite):
            path = Path(step.name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(step.text, encoding="utf-8")
            continue
        commands += 1
        assert_shown(step, _tested() if step.words[0] == "pytest" else run(step))
    return commands


def _tested() -> str:
    """Run pytest on the folder ``effects`` and return its output."""
    words = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "effects"]
    done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout.partition(" in ")[0]


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "docs").symlink_to(DOCS)
    monkeypatch.chdir(tmp_path)


@pytest.mark.large
def test_tutorial() -> None:
    """The tutorial shows the real output; ``test_commands.py`` tests these steps and the adopted
    effect on other sets."""
    assert _follow(DOCS / "tutorial.md") >= 12
    hidden = json.loads(Path("monday.truth.json").read_text(encoding="utf-8"))
    assert hidden["hidden"] == "thermal_eccentricity"


def test_first_own_table() -> None:
    assert _follow(DOCS / "first-own-table.md") >= 4


@pytest.mark.large
def test_own_effect() -> None:
    """The page about own effects shows the real output; ``test_effects.py``, ``test_commands.py``
    and ``test_effect_check.py`` also test these commands."""
    assert _follow(DOCS / "own-effect.md") >= 6


@pytest.mark.large
def test_real_data() -> None:
    """The page about real data shows the real output; ``test_real_data.py`` tests the findings for
    these sets without the commands."""
    assert _follow(DOCS / "real-data.md") >= 12


@pytest.mark.parametrize(
    ("wanted", "line", "expected"),
    [
        ("│ 0.145 │ x", "│  0.1453 │ x", True),
        ("│ 0.145 │ x", "│  0.165 │ x", False),
        ("│ 0.145 │ x", "│  0.145 │ y", False),
        ("p = 1.2e-80", "p = 3.1e-79", True),
        ("p = 1.2e-80", "p = 0.3", False),
        ("order = 126 1", "order = 108 1", False),
    ],
)
def test_comparison_of_lines(wanted: str, line: str, expected: bool) -> None:
    assert same(wanted, line) is expected


def test_a_missing_line_is_reported() -> None:
    with pytest.raises(AssertionError, match="not in the output: Verdict: named"):
        assert_shown(Command(["arctrue"], ["Verdict: named"]), "Verdict: unknown\n")


@pytest.mark.parametrize(
    "page", ["tutorial", "own-effect", "real-data", "workbench", "effects", "benchmark"]
)
def test_links_and_pictures_are_there(page: str) -> None:
    import re

    text = (DOCS / f"{page}.md").read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", text):
        assert (DOCS / target).exists(), target
