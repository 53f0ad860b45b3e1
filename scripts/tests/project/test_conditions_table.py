"""Tests that docs/hidden-effect.md has the figures of docs/data/conditions.json: the table of the
effects that depend on a condition."""

from __future__ import annotations

from pathlib import Path

import pytest

from scripts.conditions_table import STORED, main
from scripts.marked_section import MarkedSection


def test_the_page_has_the_stored_figures() -> None:
    assert STORED.exists()
    assert main(["check"]) == 0


def test_a_page_without_its_place_is_refused(tmp_path: Path) -> None:
    place = tmp_path / "page.md"
    place.write_text("# A page\n", encoding="utf-8")
    with pytest.raises(ValueError, match="lacks the lines"):
        MarkedSection(place, "<!-- made -->\n").write("a table\n")
    assert place.read_text(encoding="utf-8") == "# A page\n"
