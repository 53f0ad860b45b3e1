"""The benches' page, and the calibration beside the bound that no estimate beats."""

from __future__ import annotations

from pathlib import Path

import pytest
from scripts.bench_calibration import bound_arcsec, gateware_difference_arcsec, measure
from scripts.bench_page import BENCHES, machine, page

ROOT = Path(__file__).resolve().parents[3]


def test_calibration_reaches_the_cramer_rao_bound() -> None:
    """12 draws of 32 orders: order 11 has most of the variance, of 2·11 degrees of freedom; 4 of
    its standard deviations, 1/√(2·22), and none that is below it by as much."""
    found = measure(12)
    for error, seconds in found.values():
        assert error / bound_arcsec() == pytest.approx(1.0, abs=4.0 / (2.0 * 22) ** 0.5)
        assert seconds.shape == (12,)


def test_gateware_keeps_half_a_count_and_the_appendix() -> None:
    largest, rms, most = gateware_difference_arcsec()
    assert 0.5 * rms < largest <= most


def test_page_has_the_machine_and_every_bench_and_tells_failures() -> None:
    outputs = dict.fromkeys(BENCHES, (0, "figures\n"))
    outputs["scripts.bench_firmware"] = (1, "goal missed\n")
    text = page([("processor", "one")], outputs)
    assert text.count("```text\n") == len(BENCHES)
    assert "| processor | one |" in text
    assert text.count("**Exit code 1") == 1


def test_machine_names_what_the_figures_depend_on() -> None:
    facts = dict(machine())
    assert {"commit", "processor", "load before", "numpy", "ghdl"} <= facts.keys()


def test_make_bench_runs_the_page_and_every_bench_is_a_script() -> None:
    makefile = (ROOT / "Makefile").read_text(encoding="utf-8")
    assert "-m scripts.bench_page build/bench/page.md" in makefile
    scripts = {f"scripts.{path.stem}" for path in (ROOT / "scripts").glob("bench_*.py")}
    assert scripts - {"scripts.bench_page"} == set(BENCHES)
