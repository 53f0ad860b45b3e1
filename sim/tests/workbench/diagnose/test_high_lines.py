"""Tests products of a condition and an order above 30, which a line of the capture shows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sim.tests.workbench.small_sets import COUNTS_PER_REV, Float, measurement_set

from arctrue.workbench.diagnose.high_lines import high_lines
from arctrue.workbench.diagnose.parts_scan import (
    _with_columns_from_zero,
    best_parts,
    parts_above,
)
from arctrue.workbench.effects.part_conditions import (
    ALWAYS,
    column_condition,
    times_direction,
)
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.observations.build import observations_of
from arctrue.workbench.observations.different_stations import stations_of

ORDER = 72.0
LOADS_NM = np.array([0.0, 5.0, 2.0, 8.0])
ARCSEC_A_NM = 0.05


def _residuals(size_arcsec: Float, order: float = ORDER, seed: int = 1) -> Residuals:
    """Return the residuals of a capture in which head 2 has a line of this size in each run."""
    measured = measurement_set(seed=seed, reference=False)
    capture = measured.capture
    assert capture is not None
    angle = 2.0 * np.pi / COUNTS_PER_REV * capture.head1_counts
    moved = size_arcsec[capture.run] * np.cos(order * angle + 0.5)
    # Random rounding: a rounded line of two counts would have harmonics.
    counts = moved / 3600.0 / 360.0 * COUNTS_PER_REV
    counts += np.random.default_rng(seed).uniform(size=counts.size)
    capture.head2_counts[:] += np.floor(counts).astype(np.int64)
    capture = replace(capture, conditions={"load_nm": LOADS_NM[capture.run]})
    graduation = Term(built_in()["graduation_harmonics"](), {})
    return Residuals(fit([graduation], observations_of(replace(measured, capture=capture))))


def test_a_high_order_that_grows_with_a_load_is_described() -> None:
    """The size is 0 without load, so that the column itself is the condition, not its distance from
    the median."""
    found = parts_above(_residuals(ARCSEC_A_NM * LOADS_NM))[0]
    assert found.effect.orders == (ORDER,)
    assert found.effect.condition.column == "load_nm"
    assert found.effect.condition.column_zero == 0.0
    assert found.effect.describe({}).startswith("load_nm × order 72")


def test_a_steady_high_order_needs_no_condition() -> None:
    found = parts_above(_residuals(np.full(4, 0.2), 40.5))[0]
    assert (found.effect.orders, found.effect.condition.part) == ((40.5,), "")


def test_a_line_that_changes_its_sign_with_the_run_is_found() -> None:
    lines, orders = high_lines(_residuals(np.array([0.2, -0.2, 0.2, -0.2])), 30.0)
    assert lines == [ORDER]
    # Half and whole orders from 30.5 to below half the samples per turn.
    assert orders == pytest.approx(2 * (600 - 30), abs=4)


def test_the_products_of_the_survey_do_not_compete_with_high_orders() -> None:
    """A high order of the disc is an effect of the catalogue; no product may take its place."""
    orders = [item.effect.orders for item in best_parts(_residuals(np.full(4, 0.2)))]
    assert all(order <= 30.0 for found in orders for order in found)


@pytest.mark.parametrize("seed", range(3))
def test_noise_has_no_line(seed: int) -> None:
    assert high_lines(_residuals(np.zeros(4), seed=seed), 30.0)[0] == []


def test_each_column_is_tried_once_without_its_zero() -> None:
    """The search adds a recorded column once more, counted from 0, if it has another zero. A column
    times the direction has no design columns in a capture and adds no condition."""
    load, current = column_condition("load_nm", 12.0), column_condition("current_a", 0.0)
    given = [(item, 0.25) for item in (ALWAYS, load, current, times_direction(load))]
    found = [condition.words for condition, _ in _with_columns_from_zero(given)[len(given) :]]
    assert found == ["load_nm"]


def test_a_station_at_the_end_of_the_turn_is_the_first() -> None:
    assert stations_of(np.array([0.0, 120.0, 240.0, 359.9999, 120.0001, -0.0001])) == 3
