"""Tests that the pages repeat no withdrawn claim, and name the commit of each earlier figure."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import arctrue

ROOT = Path(__file__).resolve().parents[3]
PACKAGE = Path(arctrue.__path__[0])
TAKEN_BACK = (
    "shares no equation",
    "fixed before any data",
    "At most 1 %",
    "at most 1 % of adequate",
)


def _imported(folder: str) -> set[str]:
    found: set[str] = set()
    for path in (PACKAGE / folder).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {item.name for item in node.names}
            elif isinstance(node, ast.ImportFrom):
                found.add(node.module or "")
    return found


def test_simulated_table_and_workbench_share_no_code() -> None:
    for folder in ("table", "studies/simulate"):
        assert not [name for name in _imported(folder) if name.startswith("arctrue.workbench")]
    there = [name for name in _imported("workbench") if re.match(r"arctrue\.(table|studies)", name)]
    assert there == []


def test_what_cannot_be_shown_is_not_said() -> None:
    texts = [
        *(ROOT / "docs").rglob("*.md"),
        *PACKAGE.rglob("*.py"),
        *(ROOT / "scripts").glob("*.py"),
    ]
    for path in [*texts, ROOT / "README.md"]:
        text = " ".join(path.read_text(encoding="utf-8").split())
        assert not [claim for claim in TAKEN_BACK if claim in text], path


def _former_figures(text: str) -> list[str]:
    """Return the bracketed remarks in ``text`` that give a figure of an earlier commit."""
    return re.findall(r"\([\d.,]+ (?:[^()]*? )?before\b[^()]*\)", " ".join(text.split()))


def test_former_figures_are_found() -> None:
    text = "It has 3 LUT (4 LUT before,\n`abcdef0`), and is read (by 5 threads) before it is used."
    assert _former_figures(text) == ["(4 LUT before, `abcdef0`)"]


def test_a_figure_of_before_carries_the_commit_that_makes_it() -> None:
    """If this tree cannot reproduce a figure, the page names the commit that can."""
    for path in [*(ROOT / "docs").rglob("*.md"), ROOT / "README.md"]:
        for said in _former_figures(path.read_text(encoding="utf-8")):
            assert re.search(r"`[0-9a-f]{7}(~1)?`", said), f"{path}: {said}"
