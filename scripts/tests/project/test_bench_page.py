"""Tests the page of the benches, and that the error of the calibration reaches its lower bound."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from scripts.bench_calibration import bound_arcsec, gateware_difference_arcsec, measure
from scripts.bench_page import BENCHES, Ran, machine, page, run
from scripts.bench_rows import Row, give_out, read_rows, shown

ROOT = Path(__file__).resolve().parents[3]


def test_calibration_reaches_the_cramer_rao_bound() -> None:
    """The error of the calibration, over two groups of 10 draws, equals the Cramér–Rao bound within
    4 standard deviations.

    Of the 32 orders, order 11 has most of the variance. Two components in two groups of 10 draws
    have 2·2·9 degrees of freedom, so the relative standard deviation of the RMS error is 1/√(2·36).
    """
    found = measure(20)
    for errors, seconds in found.values():
        assert errors.shape == (2,)
        error = float(np.sqrt(np.mean(errors**2)))
        assert error / bound_arcsec() == pytest.approx(1.0, abs=4.0 / (2.0 * 36) ** 0.5)
        assert seconds.shape == (20,)


def test_gateware_keeps_half_a_count_and_the_appendix() -> None:
    largest, rms, most = gateware_difference_arcsec()
    assert 0.5 * rms < largest <= most


def test_page_has_the_machine_and_every_bench_and_tells_failures() -> None:
    facts = {"commit": "abc", "load before": "9.0"}
    rows = (Row("speed", "ms", (3.0, 1.0, 2.0), "peer 4 ms"), Row("count", "10⁶", (5.0,), "limit"))
    ran = dict.fromkeys(BENCHES, Ran(0, rows, "", facts))
    ran["scripts.bench_firmware"] = Ran(1, (), "one\nno emulator\n", facts)
    text = page([("processor", "one")], ran)
    assert "| processor | one |" in text
    assert text.count("| speed | ms | 2 | 1.5 to 2.5 | 1 to 3 | 3 | peer 4 ms |") == len(ran) - 1
    assert "| count | 10⁶ | 5 |  |  | counted | limit |" in text
    assert text.count("load before 9.0") == len(ran)
    assert text.count("**Exit code 1") == 1
    assert "no emulator" in text


def test_a_limit_that_is_not_kept_is_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = [Row("time", "s", (11.0, 12.0), "limit 10 s", kept=False)]
    file = tmp_path / "rows.json"
    assert give_out(rows, file) == 1
    assert "**limit 10 s: not kept**" in capsys.readouterr().out
    assert read_rows(file) == rows


@pytest.mark.parametrize(
    ("value", "text"), [(287_432.0, "287,000"), (1234.0, "1,230"), (0.01234, "0.0123"), (7, "7")]
)
def test_three_digits(value: float, text: str) -> None:
    assert shown(value) == text


def test_a_bench_that_ends_badly_is_a_failure(tmp_path: Path) -> None:
    ran = run("scripts.bench_of_nothing", tmp_path / "rows.json")
    assert ran.code != 0
    assert not ran.rows
    assert "No module named" in ran.text


def test_machine_names_what_the_figures_depend_on() -> None:
    facts = dict(machine())
    assert {"commit", "processor", "load before", "numpy", "ghdl"} <= facts.keys()


def test_make_bench_runs_the_page_and_every_bench_is_a_script() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert "-m scripts.bench_page build/bench/page.md" in makefile
    scripts = {f"scripts.{path.stem}" for path in (ROOT / "scripts").glob("bench_*.py")}
    assert scripts - {"scripts.bench_page", "scripts.bench_rows"} == set(BENCHES)
