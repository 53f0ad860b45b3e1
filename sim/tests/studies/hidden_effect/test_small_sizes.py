"""arctrue hidden refuses a table that is too coarse for it, and says which is not."""

from __future__ import annotations

import pytest
from click.testing import CliRunner

from arctrue.cli import main


@pytest.mark.parametrize(("interpolation", "lines"), [("64", 4096), ("256", 1024), ("1024", 256)])
def test_a_table_that_is_too_coarse_is_refused_with_one_that_is_not(
    interpolation: str, lines: int
) -> None:
    words = ["hidden", "hysteresis", "--interpolation", interpolation, "--lines", str(lines - 1)]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 2
    assert f"--lines {lines} or more" in done.output
