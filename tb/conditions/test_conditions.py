"""Tests that the VHDL of the modulators (direction, speed, words) equals their models."""

from __future__ import annotations

import pytest

from tb.support.simulation import simulate


def test_stop_operator() -> None:
    simulate("stop_operator", "tb.conditions.stop_operator_bench")


def test_table_speed() -> None:
    simulate(
        "table_speed", "tb.conditions.table_speed_bench", generics={"WINDOW": 6, "LONGEST": 10}
    )


@pytest.mark.large
def test_table_speed_on_an_eccentric_disc() -> None:
    """The error of the speed stays below 2·10⁻⁴ while the speed of the reading varies by
    ±8·10⁻⁴."""
    simulate("table_speed", "tb.conditions.table_speed_accuracy_bench")


def test_unit_divider() -> None:
    simulate("unit_divider", "tb.conditions.unit_divider_bench")


def test_slewed_word() -> None:
    simulate("slewed_word", "tb.conditions.slewed_word_bench")


def test_table_conditions() -> None:
    simulate(
        "table_conditions",
        "tb.conditions.table_conditions_bench",
        generics={"WINDOW": 8, "LONGEST": 13},
    )


@pytest.mark.parametrize(
    ("fold", "swaps"),
    [(8, 4), *(pytest.param(fold, 24, marks=pytest.mark.large) for fold in (1, 2, 4, 8))],
)
def test_modulated_pipeline(fold: int, swaps: int) -> None:
    """A pipeline with modulated amplitudes equals its model in every clock, for each FOLD."""
    simulate(
        "compensation_pipeline",
        "tb.conditions.modulated_pipeline_bench",
        generics={"LANES": 8, "FOLD": fold, "MODULATORS": "true"},
        environment={
            "LANES": "8",
            "FOLD": str(fold),
            "COUNTS_PER_REV": "65536",
            "SWAPS": str(swaps),
        },
    )
