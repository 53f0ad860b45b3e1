"""Tests that only a motion of the axis counts as a further order of a motion, on sets of four heads
whose model already has the lower orders."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet
from arctrue.workbench.diagnose.own_tests import further_motion
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.observations.build import observations_of
from tests.workbench.heads.four_heads import COUNTS, DISC, PLACES_DEG, Float, FourHeads

MATTERS_ARCSEC = 0.04
"""Half a count of 2²⁴ a turn."""


def _further(made: MeasurementSet) -> str | None:
    effects = built_in()
    motion = effects["radial_error_motion"](orders=[4, 8])
    model = [Term(effects["graduation_harmonics"](), {}), Term(motion, {})]
    left = Residuals(fit(model, observations_of(made)))
    return further_motion(SimpleNamespace(effect=motion), left, MATTERS_ARCSEC)  # type: ignore[arg-type]


def _of_orders(*orders: int) -> FourHeads:
    """Return a table whose axis moves along a line, by 0.1 µm in each order."""

    def motion(angle: Float) -> Float:
        wave = sum(np.cos(order * angle + 0.1 * order) for order in orders)
        return np.asarray(1e-7 * np.exp(0.7j) * wave)

    return FourHeads(motion=motion)


def test_orders_12_and_20_of_a_cam() -> None:
    found = _further(_of_orders(4, 8, 12, 20).measured(3))
    assert found is not None
    assert "order 12, 20" in found
    assert "repeats at orders 4, 8, 12, 20" in found


def test_two_orders_are_the_whole_motion() -> None:
    assert _further(_of_orders(4, 8).measured(3)) is None


def test_an_order_of_the_disc_is_no_motion() -> None:
    """Order 25 is above the orders of the model."""
    made = replace(_of_orders(4, 8), disc=(*DISC, (25, 0.4, 0.3))).measured(3)
    assert _further(made) is None


@pytest.mark.parametrize("head", [1, pytest.param(3, marks=pytest.mark.large)])
def test_a_wave_of_one_head_is_no_motion(head: int) -> None:
    made = _of_orders(4, 8).measured(3)
    assert made.capture is not None
    name = f"head{head}_counts"
    counts = getattr(made.capture, name)
    place = PLACES_DEG[head - 1] / 360.0
    wave = np.cos(12.0 * 2.0 * np.pi * (counts / COUNTS - place))
    moved = counts + np.round(0.4 / 1_296_000.0 * COUNTS * wave).astype(np.int64)
    assert _further(replace(made, capture=replace(made.capture, **{name: moved}))) is None
