"""Tests the comparison of lanes: its arithmetic in float64, its measurements, and its page."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import numpy as np
import pytest

from arctrue.gateware.table_rotation import error_bound
from scripts import compare_lanes
from scripts.compare_lanes import (
    AMPLITUDE,
    BEGIN,
    LANES,
    LATENCIES,
    SWEEP_BITS,
    Measured,
    WrongOutputError,
    latency_and_errors,
    sweep,
    verilog_table,
)
from scripts.marked_section import END
from scripts.netlist import ToolError
from scripts.resources import Resources

HALF_OF_LAST_BIT = 2.0**-17


def _outputs(delay: int, *, wrong: float = 0.0) -> np.ndarray:
    """Return cosines rounded to s1.16, delayed by ``delay`` clocks, with zeros before them."""
    count = 1 << SWEEP_BITS
    k = np.arange(count)
    # The low 4 of the phase's 24 bits are a multiplicative hash of k, as in the simulation.
    turns = k / count + ((k * 2654435761 % 2**32) // 2**28) / 2.0**24
    late = np.zeros(count + LATENCIES.stop)
    late[delay : delay + count] = np.round(AMPLITUDE * np.cos(2.0 * np.pi * turns) * (1.0 + wrong))
    return late


@pytest.mark.large
def test_latency_and_errors_are_those_of_the_outputs() -> None:
    latency, error, any_angle = latency_and_errors(_outputs(16))
    # The harness reads a value after the edge that takes its phase, which adds one register to the
    # delay.
    assert latency == 17
    # Rounding to the last bit has an error of at most half a bit; a million phases come close to
    # this bound.
    assert 0.99 * HALF_OF_LAST_BIT < error <= HALF_OF_LAST_BIT * (1.0 + 1e-9)
    # Over half of the last bit of a phase (2**-24 turn), the cosine changes by at most pi * 2**-24.
    assert any_angle == pytest.approx(error + np.pi * 2.0**-24, rel=0.02)
    _, error, _ = latency_and_errors(_outputs(20, wrong=1e-3))
    assert error == pytest.approx(1e-3, abs=HALF_OF_LAST_BIT)


@pytest.mark.large
def test_what_is_not_a_cosine_is_refused() -> None:
    with pytest.raises(WrongOutputError, match="no cosine comes out"):
        latency_and_errors(_outputs(16, wrong=-1.0))


def test_table_and_slope_give_the_cosine() -> None:
    folded = np.arange(2**compare_lanes.FOLDED_BITS, dtype=np.int64)
    address = folded >> compare_lanes.OFFSET_BITS
    offset = folded & (2**compare_lanes.OFFSET_BITS - 1)
    unit_turn = 2.0**-compare_lanes.PHASE_FRACTION
    slope = compare_lanes.table_slopes()[address] / 2.0**compare_lanes.SLOPE_FRACTION
    value = compare_lanes.table_values()[address] / 2.0**compare_lanes.VALUE_FRACTION
    result = value - slope * offset * unit_turn - HALF_OF_LAST_BIT
    error = np.abs(result - np.cos(2.0 * np.pi * folded / 2.0**compare_lanes.PHASE_FRACTION))
    # The terms of the bound are half of z**2/2 with z = 2**-10 turn; half of the slope's last bit
    # times 2**-10 turn; half of the value's last bit; half a unit of the offset at the steepest
    # slope.
    bound = (2.0 * math.pi * 2.0**-10) ** 2 / 4.0 + 2.0**-19 + 2.0**-21 + math.pi * unit_turn
    assert 0.5 * bound < error.max() < bound


def test_a_table_in_verilog_has_two_s_complement() -> None:
    text = verilog_table("side", 2, 3, [0, 1, -1])
    assert "function [2:0] side;" in text
    assert "input [1:0] index;" in text
    assert "2'd1: side = 3'h1;" in text
    assert "2'd2: side = 3'h7;" in text
    assert "2'd3" not in text


@pytest.mark.large
@pytest.mark.skipif(not shutil.which("verilator"), reason="needs verilator")
def test_the_netlist_of_the_table_gives_the_cosine(tmp_path: Path) -> None:
    """GHDL's netlist of the table gives the cosine at 2**20 phases, within the bound that the
    header of table_rotation derives."""
    source = tmp_path / "table_lane.v"
    source.write_text(compare_lanes.table_lane(), encoding="utf-8")
    latency, error, _ = latency_and_errors(sweep(source))
    assert latency == 17
    assert error <= error_bound()


def _versions(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compare_lanes, "find_ghdl", lambda: ("ghdl", "GHDL 5.0.1"))
    monkeypatch.setattr(compare_lanes, "find_yosys", lambda: ("yosys", "Yosys 0.23"))
    monkeypatch.setattr(compare_lanes, "verilator_version", lambda: "5.006")


def test_the_table_is_written_between_the_marks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _versions(monkeypatch)
    used = Resources(lut=560, ff=558, carry4=141, dsp=0)
    found = Measured(used, 4.6, 17, 5.25e-5, 5.27e-5)
    monkeypatch.setattr(compare_lanes, "measure", lambda *_: found)
    page = tmp_path / "page.md"
    page.write_text(f"before\n{BEGIN}old\n{END}after\n", encoding="utf-8")
    assert compare_lanes.main(["--page", str(page)]) == 0
    text = page.read_text(encoding="utf-8")
    assert text.startswith(f"before\n{BEGIN}GHDL 5.0.1, Yosys 0.23")
    assert text.endswith(f"|\n{END}after\n")
    assert "\nold\n" not in text
    for name in LANES:
        assert f"| {name} | 560 | 558 | 141 | 0 | 0 | 17 | 4.6 | 5.25e-05 | 5.27e-05 |" in text


def test_the_page_in_the_tree_has_every_lane_between_its_marks() -> None:
    text = compare_lanes.PAGE.read_text(encoding="utf-8")
    measured = text.partition(BEGIN)[2].partition(END)[0]
    assert all(f"| {name} |" in measured for name in LANES)


def test_a_missing_tool_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def missing(*_: object) -> Measured:
        raise ToolError("verilator is missing")

    monkeypatch.setattr(compare_lanes, "measure", missing)
    page = tmp_path / "page.md"
    for text, message in (
        (f"{BEGIN}{END}", "verilator is missing"),
        ("page", "page.md lacks the lines <!--"),
    ):
        page.write_text(text, encoding="utf-8")
        assert compare_lanes.main(["--page", str(page)]) == 2
        assert message in capsys.readouterr().err
        assert page.read_text(encoding="utf-8") == text
