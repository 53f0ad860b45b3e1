"""Tests that the latencies in the pages equal those of the number formats and of the models."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from arctrue.gateware.latency import pin_to_pin_clocks, pipeline_clocks
from arctrue.generated.number_formats import (
    COMPENSATION_LATENCY,
    DELAY_LINE_LATENCY,
    HARMONIC_LATENCY,
    PHASE_LATENCY,
    PIPELINE_LATENCY,
)

ROOT = Path(__file__).resolve().parents[3]
CLOCK_NS = 10
CORE = "rtl/core/arctrue_core.vhd"


def _text(name: str) -> str:
    return " ".join((ROOT / name).read_text(encoding="utf-8").split())


def _pin_to_pin(fold: int) -> str:
    least, most = pin_to_pin_clocks(fold)
    return f"{least} clocks" if least == most else f"{least} to {most} clocks"


def test_the_paper_table_1_is_the_unfolded_pipeline() -> None:
    assert (PHASE_LATENCY, HARMONIC_LATENCY, COMPENSATION_LATENCY) == (5, 20, 4)
    assert pipeline_clocks() == 29 == DELAY_LINE_LATENCY + COMPENSATION_LATENCY


@pytest.mark.parametrize("heads", [2, 3, 4])
@pytest.mark.parametrize("fold", [1, 2, 4, 8])
def test_the_latency_is_the_constant_of_the_core(fold: int, heads: int) -> None:
    """``CORE_LATENCY`` in the VHDL, which the register ``pipeline.latency`` states.
    ``tb/core/test_pin_to_pin.py`` measures the core."""
    sum_ = re.search(r"constant CORE_LATENCY +: positive := ([^;]+);", _text(CORE))
    assert sum_
    known = {
        "PIPELINE_LATENCY": PIPELINE_LATENCY,
        "FOLD": fold,
        "boolean'pos(HEADS > 2)": heads > 2,
    }
    terms = re.fullmatch(r"(.+) \+ (.+) - 1 \+ (.+)", sum_[1])
    assert terms, sum_[1]
    clocks = sum(known[term] for term in terms.groups()) - 1
    assert pipeline_clocks(fold, heads) == clocks
    shorter = pin_to_pin_clocks(fold)
    assert pin_to_pin_clocks(fold, heads) == tuple(one + (heads > 2) for one in shorter)


def test_timing_says_the_clock_of_three_or_four_heads() -> None:
    assert pipeline_clocks(1, 3) == pipeline_clocks(1, 4) == pipeline_clocks() + 1
    assert "with three or four heads one more, also from pin to pin." in _text("docs/timing.md")


@pytest.mark.parametrize("fold", [1, 2, 4, 8])
def test_table_of_the_folds(fold: int) -> None:
    clocks = pipeline_clocks(fold)
    row = (
        f"| {fold} | {fold * CLOCK_NS} ns | {clocks} clocks, {clocks * CLOCK_NS} ns "
        f"| {(clocks + fold - 1) * CLOCK_NS} ns | {_pin_to_pin(fold)} |"
    )
    assert row in _text("docs/timing.md")


@pytest.mark.parametrize(("fold", "every"), [(1, "every clock"), (2, "every 2 clocks")])
def test_table_of_the_readme(fold: int, every: str) -> None:
    rows = re.findall(
        r"\| ([^|]*FOLD = (\d)[^|]*) \| ([^|]*) \| ([^|]*) \| ([^|]*) \|", _text("README.md")
    )
    found = {int(row[1]): row[2:] for row in rows}
    assert found[fold] == (every, f"{pipeline_clocks(fold)} clocks", _pin_to_pin(fold))


def test_architecture_says_both_forms() -> None:
    text = _text("docs/architecture.md")
    ns = pipeline_clocks() * CLOCK_NS
    assert f"within {pipeline_clocks()} clocks ({ns} ns at 100 MHz), one angle a clock" in text
    assert (
        "With 2 lanes in a pipeline, as the open flow builds it, "
        f"the latency is {pipeline_clocks(2)} clocks, with an angle every 2 clocks."
    ) in text


def test_what_was_routed_is_folded() -> None:
    text = _text("docs/timing.md")
    row = r"\| `arctrue_zynq_top`, 32 lanes folded by (\d), at `[0-9a-f]+` \| 100 \|"
    routed = re.search(row, text)
    assert routed, "the table of routed designs names the fold"
    assert routed[1] == "2"
