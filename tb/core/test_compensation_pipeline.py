"""The whole pipeline in VHDL equals its model bit by bit, and the model equals equation (9)."""

from __future__ import annotations

import pytest

from tb.support.simulation import simulate

TOPLEVEL = "compensation_pipeline"
BENCH = "tb.core.compensation_pipeline_bench"


def run(
    testcase: str,
    lanes: int,
    angles: int = 0,
    counts_per_rev: int = 2**24,
    sum_counts: float = 0.0,
    cosine_width: int = 18,
) -> None:
    simulate(
        TOPLEVEL,
        BENCH,
        generics={"LANES": lanes, "COSINE_WIDTH": cosine_width},
        testcase=testcase,
        environment={
            "LANES": str(lanes),
            "ANGLES": str(angles),
            "COUNTS_PER_REV": str(counts_per_rev),
            "SUM_COUNTS": str(sum_counts),
            "COSINE_WIDTH": str(cosine_width),
        },
        # 32 lanes run three times as fast as in mcode.
        backend="llvm",
    )


@pytest.mark.slow
def test_a_turn_of_12000_angles_with_the_default_lanes() -> None:
    run("a_turn_of_angles", lanes=32, angles=12_000)


@pytest.mark.parametrize(
    ("lanes", "counts_per_rev", "sum_counts"),
    [
        (1, 2**24, 8191.0),
        (3, 4, 0.4),
        (4, 1000, 300.0),
        (5, 65_536, 0.0),
        (8, 12_345_677, 60_000.0),
        (64, 16_777_213, 0.0),
    ],
)
def test_other_configurations(lanes: int, counts_per_rev: int, sum_counts: float) -> None:
    run(
        "a_turn_of_angles",
        lanes,
        angles=300 if lanes == 64 else 500,
        counts_per_rev=counts_per_rev,
        sum_counts=sum_counts,
    )


def test_another_width_of_the_cosine() -> None:
    run("a_turn_of_angles", lanes=2, angles=500, cosine_width=14)


def test_latencies() -> None:
    run("latencies_of_table_1", lanes=4)


@pytest.mark.parametrize("counts_per_rev", [5000, 2**24])
def test_swap_and_bypass_under_load(counts_per_rev: int) -> None:
    run("swap_and_bypass_under_load", lanes=4, angles=6000, counts_per_rev=counts_per_rev)


def test_reset_under_load() -> None:
    run("reset_under_load", lanes=2)
