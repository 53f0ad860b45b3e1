"""Tests that ``arctrue hidden`` refuses tables with too few lines and states the smallest possible
number, and refuses --follow for an effect that does not change order 1 with the temperature.
"""

from __future__ import annotations

import pytest
from click.testing import CliRunner

from arctrue.cli import main
from arctrue.studies.hidden_effect.cases import CASES


@pytest.mark.parametrize(("interpolation", "lines"), [("64", 4096), ("256", 1024), ("1024", 256)])
def test_a_table_that_is_too_coarse_is_refused_with_one_that_is_not(
    interpolation: str, lines: int
) -> None:
    words = ["hidden", "hysteresis", "--interpolation", interpolation, "--lines", str(lines - 1)]
    done = CliRunner().invoke(main, words)
    assert done.exit_code == 2
    assert f"--lines {lines} or more" in done.output


@pytest.mark.parametrize("effect", [name for name, case in CASES.items() if not case.order1_warms])
def test_order_1_is_followed_only_where_heat_changes_it(effect: str) -> None:
    done = CliRunner().invoke(main, ["hidden", effect, "--follow"])
    assert done.exit_code == 2
    said = " ".join(done.output.split())
    assert f"{effect} does not change; use --follow with thermal_eccentricity" in said
