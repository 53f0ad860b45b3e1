"""The table of effects that follow a condition has the stored figures."""

from __future__ import annotations

import pytest

from scripts.conditions_table import STORED, main, page


def test_the_page_has_the_stored_figures() -> None:
    assert STORED.exists()
    assert main(["check"]) == 0


def test_a_page_without_its_place_is_refused() -> None:
    with pytest.raises(ValueError, match="no place"):
        page("# A page", {})
