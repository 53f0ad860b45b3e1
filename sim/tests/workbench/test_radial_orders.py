"""Tests which orders of a radial motion are kept; ordinary least squares of numpy gives the
gains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Effect, FitContext, Nonlinear
from arctrue.workbench.effects.catalogue.radial_error_motion import RadialErrorMotion
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of
from tests.workbench.small_sets import measurement_set

Float = NDArray[np.float64]
NOISE_ARCSEC = 0.1


@dataclass
class Leftover:
    """Residuals of a reference whose model is a constant."""

    observations: Observations
    residual_arcsec: Float

    def _left(self, columns: Float) -> float:
        found, *_ = np.linalg.lstsq(columns, self.residual_arcsec, rcond=None)
        return float(np.sum((self.residual_arcsec - columns @ found) ** 2))

    def score(self, effect: Effect, nonlinear: Nonlinear) -> SimpleNamespace:
        rows = self.observations.reference
        assert rows is not None
        ones = np.ones((rows.run.size, 1))
        columns = effect.reference_columns(rows, nonlinear, FitContext())
        assert columns is not None
        gain = self._left(ones) - self._left(np.hstack([ones, columns]))
        return SimpleNamespace(gain=gain / NOISE_ARCSEC**2)

    def scores(self, asked: Sequence[tuple[Effect, Nonlinear]]) -> list[SimpleNamespace]:
        return [self.score(effect, nonlinear) for effect, nonlinear in asked]


def test_uneven_stations_add_no_order() -> None:
    """At 48 stations at uneven angles, a motion of order 2 and 1″ gives other orders a gain far
    above the penalty, if each order is tested alone."""
    measured = measurement_set(cycles=1)
    random = np.random.default_rng(3)
    assert measured.reference is not None
    rows = measured.reference.target_deg.size
    measured.reference.target_deg[:] = np.sort(random.uniform(0.0, 360.0, rows) ** 1.5 / 19.0)
    observations = observations_of(measured)
    assert observations.reference is not None
    angle = observations.reference.angle_rad
    residual = np.cos(2.0 * angle + 0.4) + random.normal(0.0, NOISE_ARCSEC, angle.size)
    leftover = Leftover(observations, residual)
    alone = [
        order
        for order in range(2, 9)
        if leftover.score(RadialErrorMotion(orders=[order]), {}).gain > 50.0
    ]
    assert len(alone) > 2
    kept, trials = RadialErrorMotion().narrowed(leftover)
    assert kept.settings["orders"] == [2]
    assert trials == 7.0


class _EqualOrders:
    """A capture of four heads in which each of some orders removes an equal and large part."""

    observations = SimpleNamespace(
        heads=4, reference=None, capture=SimpleNamespace(run=np.zeros(6000))
    )

    def __init__(self, orders: Sequence[int]) -> None:
        self.orders = set(orders)

    def scores(self, asked: Sequence[tuple[Effect, Nonlinear]]) -> list[SimpleNamespace]:
        kept = [self.orders & set(effect.integers("orders")) for effect, _ in asked]
        return [SimpleNamespace(gain=1000.0 * len(orders)) for orders in kept]


@pytest.mark.parametrize(("orders", "trials"), [(range(1, 9), 1.0), (range(2, 9), 8.0)])
def test_four_heads_keep_order_1_with_all_the_others(orders: Sequence[int], trials: float) -> None:
    """Eight orders are tried: all eight are one choice, and seven of them are eight choices."""
    kept, choices = RadialErrorMotion().narrowed(cast(Any, _EqualOrders(orders)))
    assert kept.settings["orders"] == list(orders)
    assert choices == trials
