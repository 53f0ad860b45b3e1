"""Tests that documents agree with the tree: generated pages, links, make targets, mutations."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from scripts.make_docs import (
    first_sentence,
    read_header,
    read_items,
    stale_documents,
)
from scripts.make_effects_page import PAGE, effects_page
from scripts.mutate import MUTATIONS, faults_of_list

ROOT = Path(__file__).resolve().parents[3]
DOCUMENTS = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
LINK = re.compile(r"!?\[[^\]]*\]\(([^)#\s]+)(?:#[^)]*)?\)")


MADE_PAGES = frozenset(
    [
        "api",
        "benchmark",
        "benchmark-sets",
        "calibration-budget",
        "commands",
        "effects",
        "head-angle",
        "heads",
        "long-run",
        "methods",
        "monte-carlo",
        "nightly",
        "number-formats",
        "paper",
        "proofs",
        "registers",
        "stop-and-go",
        "systems",
    ]
)
"""Pages of docs/ that a script or a command writes as a whole; docs/entities contains further such
pages."""
WORD = re.compile(r"\S*\w\S*")
MADE_SECTION = re.compile(
    r"<!-- [^>]*(?:python -m|scripts/|make )[^>]*-->.*?<!-- end -->", re.S | re.I
)
"""Pattern of text that a command writes; its first line names the command."""


def words_by_hand() -> dict[Path, int]:
    """Return the number of hand-written words of every page; a sign between table cells is not a
    word."""
    return {
        page: len(WORD.findall(MADE_SECTION.sub("", page.read_text(encoding="utf-8"))))
        for page in DOCUMENTS
        if page.stem not in MADE_PAGES
        and page.parent.name != "entities"
        and page.name != "CHANGELOG.md"
    }


def test_no_page_has_marks_of_a_conflict() -> None:
    marks = ("<" * 7 + " ", ">" * 7 + " ")
    found = [
        f"{page.relative_to(ROOT)}:{number}"
        for page in DOCUMENTS
        for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), start=1)
        if line.startswith(marks)
    ]
    assert found == []


def test_pages_by_hand_are_short() -> None:
    """No hand-written page has more than 2,500 words, the limit in CONTRIBUTING.md."""
    assert {page.name: words for page, words in words_by_hand().items() if words > 2500} == {}


def test_pages_by_hand_together_are_short() -> None:
    """All hand-written pages together have at most 45,000 words, the limit in CONTRIBUTING.md."""
    assert sum(words_by_hand().values()) <= 45_000


def test_made_documents_are_fresh() -> None:
    assert stale_documents(ROOT) == [], "run 'make docs'"


def test_the_effects_page_is_fresh() -> None:
    written = (ROOT / "docs" / PAGE.name).read_text(encoding="utf-8")
    assert written == effects_page(), "run 'make docs'"


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_links_lead_somewhere(document: Path) -> None:
    targets = LINK.findall(document.read_text(encoding="utf-8"))
    local = [target for target in targets if "://" not in target]
    dead = [target for target in local if not (document.parent / target).exists()]
    assert dead == []


def test_architecture_names_every_folder() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    folders = {path.name for path in (ROOT / "rtl").iterdir() if path.is_dir()}
    missing = {folder for folder in folders if f"rtl/{folder}`" not in text}
    assert missing == set()
    named = re.findall(r"`((?:rtl|sim/arctrue)/\w+)`", text)
    assert [folder for folder in named if not (ROOT / folder).exists()] == []


def test_commands_of_the_documents_are_targets() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    targets = set(re.findall(r"^([a-z-]+):", makefile, re.MULTILINE))
    for document in DOCUMENTS:
        text = document.read_text(encoding="utf-8")
        used = set(re.findall(r"(?:^|`)make ([a-z-]+)", text, re.MULTILINE))
        assert used <= targets, document


def test_help_lists_every_target() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    phony = re.search(r"^\.PHONY: (.*)$", makefile, re.MULTILINE)
    assert phony
    listing = subprocess.run(
        ["make", "--no-print-directory", "help"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    listed = re.findall(r"^  make ([a-z-]+) +\S", listing, re.MULTILINE)
    assert listed == phony[1].split()


def test_ci_runs_the_command_of_the_readme() -> None:
    run = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    commands = [line for line in run.splitlines() if line.strip() and not line.startswith("#")]
    assert commands[-1].split()[-1] == "test"
    assert "make test" in readme


def test_mutations_fit_the_tree() -> None:
    assert faults_of_list(ROOT, MUTATIONS) == []


def test_mutation_list_with_faults_is_refused(tmp_path: Path) -> None:
    (tmp_path / "rtl").mkdir()
    mutation = MUTATIONS[0]
    (tmp_path / mutation.file).parent.mkdir(parents=True)
    (tmp_path / mutation.file).write_text(mutation.old * 2, encoding="utf-8")
    faults = faults_of_list(tmp_path, (mutation, mutation))
    assert any("2 times" in fault for fault in faults)
    assert any("there is no" in fault for fault in faults)
    assert any("two mutations" in fault for fault in faults)


def test_header_without_licence_is_refused() -> None:
    with pytest.raises(ValueError, match="SPDX"):
        read_header(["library ieee;"], Path("some.vhd"))


def test_header_of_another_name_is_refused() -> None:
    lines = ["-- SPDX-License-Identifier: Apache-2.0", "--", "# other"]
    lines[2] = "-- # other"
    with pytest.raises(ValueError, match="other"):
        read_header(lines, Path("some.vhd"))


def test_ports_of_a_clause() -> None:
    clause = """
    clock : in    std_ulogic;
    -- The pins
    a, b  : in    std_ulogic_vector(N - 1 downto 0) := (others => '0'); -- level | asynchronous
    count : out   u_unsigned(3 downto 0)  -- edges
    """
    clock, pins, count = read_items(clause, Path("some.vhd"))
    assert (clock.names, clock.mode, clock.type_, clock.heading) == (
        "clock",
        "in",
        "std_ulogic",
        "",
    )
    assert (pins.names, pins.heading, pins.default) == ("a, b", "The pins", "(others => '0')")
    assert (count.mode, count.type_, count.remark) == ("out", "u_unsigned(3 downto 0)", "edges")


def test_first_sentence() -> None:
    assert first_sentence("Adds 1.5 to\nx. Then more.\n\nMore.") == "Adds 1.5 to x."
