"""Tests that the pipeline in VHDL equals its model bit by bit, and is near equation (9)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tb.support.simulation import simulate

TOPLEVEL = "compensation_pipeline"
BENCH = "tb.core.compensation_pipeline_bench"
FOLDS = (1, 2, 4, 8)


def run(
    testcase: str,
    lanes: int,
    angles: int = 0,
    counts_per_rev: int = 2**24,
    sum_counts: float = 0.0,
    cosine_width: int = 18,
    fold: int = 1,
    found_file: Path | None = None,
    rotation: str = "cordic",
) -> None:
    simulate(
        TOPLEVEL,
        BENCH,
        generics={
            "LANES": lanes,
            "COSINE_WIDTH": cosine_width,
            "FOLD": fold,
            "ROTATION": rotation,
        },
        testcase=testcase,
        environment={
            "LANES": str(lanes),
            "ANGLES": str(angles),
            "COUNTS_PER_REV": str(counts_per_rev),
            "SUM_COUNTS": str(sum_counts),
            "COSINE_WIDTH": str(cosine_width),
            "FOLD": str(fold),
            "ROTATION": rotation,
            "FOUND_FILE": str(found_file or ""),
        },
    )


@pytest.mark.large
def test_a_turn_of_12000_angles_with_the_default_lanes() -> None:
    run("a_turn_of_angles", lanes=32, angles=12_000)


@pytest.mark.parametrize(
    ("lanes", "counts_per_rev", "sum_counts"),
    [
        (1, 2**24, 8191.0),
        (3, 4, 0.4),
        pytest.param(4, 1000, 300.0, marks=pytest.mark.large),
        pytest.param(5, 65_536, 0.0, marks=pytest.mark.large),
        pytest.param(8, 12_345_677, 60_000.0, marks=pytest.mark.large),
        pytest.param(64, 16_777_213, 0.0, marks=pytest.mark.large),
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


@pytest.mark.large
def test_folds_give_the_same_corrections(tmp_path: Path) -> None:
    """The corrections of every fold equal, bit for bit, the corrections of the model and of the
    unfolded pipeline."""
    found = []
    for fold in FOLDS:
        file = tmp_path / f"{fold}.npy"
        run("a_turn_of_angles", lanes=8, angles=300, fold=fold, found_file=file)
        found.append(np.load(file))
        assert np.array_equal(found[-1], found[0]), f"FOLD = {fold} and FOLD = 1 differ"
    assert len(found[0]) == 300


@pytest.mark.parametrize(
    "fold",
    [
        1,
        pytest.param(2, marks=pytest.mark.large),
        pytest.param(4, marks=pytest.mark.large),
        pytest.param(8, marks=pytest.mark.large),
    ],
)
def test_lanes_with_a_table(fold: int) -> None:
    """Lanes with ROTATION = table equal their model, and are within the table's bound of equation
    (9), for every fold."""
    run("a_turn_of_angles", lanes=8, angles=300, fold=fold, rotation="table")


@pytest.mark.large
@pytest.mark.parametrize("fold", [1, 4])
def test_swap_and_latencies_with_a_table(fold: int) -> None:
    """With ROTATION = table, swaps and latencies take as many clocks as with the CORDIC."""
    run("latencies_of_table_1", lanes=8, fold=fold, rotation="table")
    run(
        "swap_and_bypass_under_load",
        lanes=4,
        angles=2000,
        counts_per_rev=5000,
        fold=fold,
        rotation="table",
    )


def test_an_unknown_rotation_is_refused(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises((RuntimeError, SystemExit, FileNotFoundError)):
        run("a_turn_of_angles", lanes=2, angles=10, rotation="vector")
    output = capfd.readouterr()
    assert "ROTATION is vector; expected cordic or table" in output.out + output.err


@pytest.mark.parametrize(
    ("lanes", "fold", "cosine_width"),
    [
        pytest.param(2, 2, 18, marks=pytest.mark.large),
        pytest.param(6, 2, 18, marks=pytest.mark.large),
        (4, 2, 20),
        pytest.param(64, 8, 18, marks=pytest.mark.large),
    ],
)
def test_other_folded_configurations(lanes: int, fold: int, cosine_width: int) -> None:
    """LANES / FOLD is 1 in the first case and odd in the second. The third case has truncated pair
    sums, the fourth the largest number of lanes."""
    run("a_turn_of_angles", lanes, angles=200, fold=fold, cosine_width=cosine_width)


@pytest.mark.large
def test_32_lanes_folded_by_4() -> None:
    run("a_turn_of_angles", lanes=32, angles=1_000, fold=4)


@pytest.mark.parametrize(
    ("lanes", "fold", "cosine_width", "message"),
    [
        (6, 4, 18, "LANES = 6 is not a multiple of FOLD = 4"),
        (6, 3, 18, "FOLD is 3; expected 1, 2, 4 or 8"),
        (2, 2, 20, "a cosine of more than 18 bits needs an even LANES / FOLD"),
    ],
)
def test_folds_that_do_not_fit_are_refused(
    lanes: int, fold: int, cosine_width: int, message: str, capfd: pytest.CaptureFixture[str]
) -> None:
    # The simulation stops before its first test, so the runner finds no results.
    with pytest.raises((RuntimeError, SystemExit, FileNotFoundError)):
        run("a_turn_of_angles", lanes, angles=10, fold=fold, cosine_width=cosine_width)
    output = capfd.readouterr()
    assert message in output.out + output.err


@pytest.mark.parametrize(
    "fold", [1, *(pytest.param(f, marks=pytest.mark.large) for f in (2, 4)), 8]
)
def test_latencies(fold: int) -> None:
    run("latencies_of_table_1", lanes=8, fold=fold)


@pytest.mark.parametrize("counts_per_rev", [5000, pytest.param(2**24, marks=pytest.mark.large)])
def test_swap_and_bypass_under_load(counts_per_rev: int) -> None:
    run("swap_and_bypass_under_load", lanes=4, angles=6000, counts_per_rev=counts_per_rev)


@pytest.mark.parametrize(
    "fold", [pytest.param(2, marks=pytest.mark.large), pytest.param(4, marks=pytest.mark.large), 8]
)
def test_folded_swaps_are_atomic(fold: int) -> None:
    """Each angle is corrected with one bank in all FOLD clocks in which its lanes are computed, and
    the correction makes no step."""
    run("swap_and_bypass_under_load", lanes=8, angles=3000, counts_per_rev=5000, fold=fold)


@pytest.mark.parametrize(
    "fold", [*(pytest.param(f, marks=pytest.mark.large) for f in (1, 2, 4)), 8]
)
def test_zeros_move_between_two_angles(fold: int) -> None:
    run("zeros_move_between_two_angles", lanes=8, fold=fold)


@pytest.mark.parametrize("fold", [pytest.param(1, marks=pytest.mark.large), 2])
def test_reset_under_load(fold: int) -> None:
    run("reset_under_load", lanes=2, fold=fold)


@pytest.mark.parametrize(
    ("fold", "lanes", "counts_per_rev", "testcase"),
    [
        (4, 4, 2048, "both_ways_and_tremble"),
        pytest.param(1, 2, 1024, None, marks=pytest.mark.large),
        pytest.param(4, 4, 2048, None, marks=pytest.mark.large),
        pytest.param(1, 4, 2048, None, marks=pytest.mark.large),
    ],
    ids=["4-turn", "1-2-all", "4-4-all", "1-4-all"],
)
def test_real_orders(fold: int, lanes: int, counts_per_rev: int, testcase: str | None) -> None:
    """Corrections by lanes of real orders (not integers), whose phases continue from turn to turn,
    equal the model in every clock."""
    simulate(
        TOPLEVEL,
        "tb.core.real_orders_pipeline_bench",
        generics={"LANES": lanes, "FOLD": fold, "REAL_ORDERS": "true"},
        testcase=testcase,
        environment={
            "LANES": str(lanes),
            "FOLD": str(fold),
            "COUNTS_PER_REV": str(counts_per_rev),
        },
    )
