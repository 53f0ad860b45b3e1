"""Tests that the diagnosis refuses a product of parts as a description if the product only cancels
the model's own columns.

Var(y) = Var(part) + Var(other) + 2 cov: a part that is larger than the measured error must cancel
other columns of the model.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.parts_range import only_cancels, resolved_orders
from arctrue.workbench.diagnose.parts_scan import best_parts
from arctrue.workbench.effects.part_conditions import ALWAYS, column_condition
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.effects.registry import catalogue
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.model.model import default_model
from arctrue.workbench.observations.build import observations_of

Float = NDArray[np.float64]

STEP_S, SWEEP_S, SWEEPS = 0.1, 18.0, 7
TIME_S: Float = np.arange(int(SWEEP_S * SWEEPS / STEP_S), dtype=np.float64) * STEP_S
RUN = (TIME_S // SWEEP_S).astype(np.int64)
UP = RUN % 2 == 0
STROKE = np.where(UP, TIME_S / SWEEP_S - RUN, 1.0 - TIME_S / SWEEP_S + RUN)
"""Position of each row as a fraction of the stroke, for seven sweeps up and down."""
AT_ONE_END = 5000.0 * np.exp(-60.0 * STROKE)
"""Error in arcseconds that exists only within a sixtieth of the stroke, as from a stop, a cable, or
a seam of the scale."""


def _sweeps(further_arcsec: Float, turns: float = 1.0, load: Float | None = None) -> Residuals:
    """Return the residuals of the usual model for a set with an error of order 1, a further error
    and 100″ of noise."""
    angle_rad = 2.0 * np.pi * turns * STROKE
    noise_arcsec = np.random.default_rng(7).normal(0.0, 100.0, TIME_S.size)
    reference = Reference(
        target_deg=np.degrees(angle_rad),
        error_arcsec=3000.0 * np.cos(angle_rad + 0.3) + further_arcsec + noise_arcsec,
        time_s=TIME_S,
        run=RUN,
        direction=np.where(UP, 1.0, -1.0),
        conditions={} if load is None else {"load_nm": load},
    )
    observations = observations_of(MeasurementSet(Table(), None, reference))
    return Residuals(fit(default_model().terms(catalogue()), observations))


def _rms_arcsec(residuals: Residuals, effect: ProductOfParts) -> tuple[float, float]:
    """Return the RMS of the product's prediction and of the measured rows, each about its mean."""
    rows = residuals.observations.reference
    assert rows is not None
    columns = effect.reference_columns(rows, {}, residuals.solution.context)
    assert columns is not None
    moved = columns @ residuals.score(effect, {}).coefficients
    return float(np.std(moved)), float(np.std(rows.error_arcsec))


def test_a_half_order_on_one_turn_is_a_step_at_its_seam() -> None:
    """The half order is refused: to describe 5,000″ at the seam, order 0.5 would need an amplitude
    of 36,000″, five times the measured error."""
    residuals = _sweeps(AT_ONE_END)
    half = ProductOfParts.of(ALWAYS, (0.5,), "reference")
    moved, measured = _rms_arcsec(residuals, half)
    assert moved > 4.0 * measured
    assert only_cancels(residuals, half, residuals.score(half, {}))
    found = best_parts(residuals)
    assert found
    for item in found:
        assert all(order % 1.0 == 0.0 for order in item.effect.orders)
        moved, measured = _rms_arcsec(residuals, item.effect)
        assert moved < measured


@pytest.mark.parametrize("order", [0.5, 1.5])
def test_a_half_order_that_repeats_is_described(order: float) -> None:
    """The diagnosis describes the half order of an error of 300″ if the rows cover three turns: the
    two turns of its period and one more."""
    residuals = _sweeps(300.0 * np.cos(order * 6.0 * np.pi * STROKE + 0.8), turns=3.0)
    assert best_parts(residuals)[0].effect.orders == (order,)


def test_the_zero_of_a_condition_is_a_convention() -> None:
    """The zero of a condition must not change the result. With a load of 30 ± 1 N m and 400″ of
    order 1 per N m, the product is 12,000″ if the load is counted from 0 N m.

    The model's own order 1 absorbs the mean, so that only the variation of ± 400″ counts.
    """
    load = 30.0 + np.sin(2.0 * np.pi * TIME_S / 50.0)
    error = 400.0 * (load - 30.0) * np.cos(2.0 * np.pi * STROKE + 1.0)
    residuals = _sweeps(error - 3000.0 * np.cos(2.0 * np.pi * STROKE + 0.3), load=load)
    part = ProductOfParts.of(column_condition("load_nm", 0.0), (1.0,), "reference")
    score = residuals.score(part, {})
    moved, measured = _rms_arcsec(residuals, part)
    assert moved > 10.0 * measured
    assert score.own_share < 0.01
    assert not only_cancels(residuals, part, score)


def test_a_condition_that_ends_after_a_bump_has_no_order() -> None:
    """A condition that lasts for a short part of each sweep resolves only high orders. The
    condition exp(−t/0.5 s) lasts for 9° of a sweep at 20°/s, in which only orders of 30 and more
    have 0.75 periods.
    """
    rows = _sweeps(AT_ONE_END).observations.reference
    assert rows is not None
    start = np.exp(-(TIME_S - RUN * SWEEP_S) / 0.5)
    orders = np.arange(1.0, 61.0)
    shown = resolved_orders(rows, start, orders)
    # The sum over steps of 2°, each weighted with exp(−t/τ) at the end of the step, is a geometric
    # series.
    way_deg = 2.0 / (np.exp(0.1 / 0.5) - 1.0)
    assert list(shown) == list(orders * way_deg / 360.0 >= 0.75)
    assert resolved_orders(rows, np.ones(TIME_S.size), orders).all()


@pytest.mark.parametrize("names", [(-1, 1), (202_611_271_200, 2)])
def test_the_names_of_the_runs_do_not_count(names: tuple[int, int]) -> None:
    """Runs may have any whole numbers as names, for example −1 or a date with its time; the orders
    that they resolve are the same."""
    rows = _sweeps(np.zeros(TIME_S.size)).observations.reference
    assert rows is not None
    factor, orders = np.exp(-TIME_S / 20.0), np.arange(0.5, 20.0, 0.5)
    named = replace(rows, run=np.where(rows.run % 2, *names))
    numbered = replace(rows, run=rows.run % 2)
    found = resolved_orders(named, factor, orders)
    assert found.any()
    assert found.tolist() == resolved_orders(numbered, factor, orders).tolist()


def test_a_refined_settling_still_passes_its_wave() -> None:
    """With the refined time constant, the settling still lasts for 0.75 periods of its wave. A bump
    at each start settles in 2 s, which is 40° at 20°/s, a third of a period of order 3.

    Of the time constants on the grid, the smallest one that lasts for 0.75 periods describes the
    bump best. The refinement must not go below this time constant, although a smaller one would fit
    better.
    """
    since = TIME_S - RUN * SWEEP_S
    residuals = _sweeps(4000.0 * np.exp(-since / 2.0) * np.cos(6.0 * np.pi * STROKE + 1.0))
    rows = residuals.observations.reference
    assert rows is not None
    found = best_parts(residuals)
    assert any(item.effect.condition.time_constant_s and item.effect.orders for item in found[:2])
    for item in found:
        factor = item.effect.condition.values(rows)
        assert factor is not None
        assert resolved_orders(rows, factor, np.array(item.effect.orders)).all()
