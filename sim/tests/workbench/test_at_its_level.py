"""Tests the degrees of freedom of an effect in noise of changing level."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.at_its_level import _gain, gains_at_its_level
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import single_p_value
from arctrue.workbench.noise.fit import white_noise
from arctrue.workbench.observations.build import observations_of

ROWS, DRAWS = 100, 2000


@pytest.mark.parametrize("louder", [1.0, 3.0])
def test_p_of_a_slow_column_is_that_of_chance(louder: float) -> None:
    """With and without three louder rows of 30, p < 0.01 occurs in about 1 % of 2,000 draws: in
    0.35 % to 1.67 %, three standard deviations from 1 %. If the fourth power of a residual counted
    as σ⁴, not as 3σ⁴, it would occur in fewer than 0.35 %."""
    random = np.random.default_rng(41)
    column = np.linspace(-1.0, 1.0, 30)[:, np.newaxis]
    level = np.where((np.arange(30) >= 10) & (np.arange(30) < 13), louder, 1.0)
    found = [_gain(level * random.normal(size=30), column, with_effect=True) for _ in range(DRAWS)]
    p_values = np.array([single_p_value(item.gain, 1, item.freedom) for item in found])
    assert 0.0035 <= float(np.mean(p_values < 0.01)) <= 0.0167


def test_equal_rows_are_all_degrees_of_freedom() -> None:
    """Each row has the same weight in the sum of the squares of the residuals; the fit takes one
    degree of freedom."""
    random = np.random.default_rng(42)
    column = np.ones((ROWS, 1))
    found = [_gain(random.normal(size=ROWS), column, with_effect=True) for _ in range(DRAWS)]
    # The estimates of 2,000 draws scatter by some 15 %, their mean by 0.3 %.
    assert float(np.mean([item.freedom for item in found])) == pytest.approx(ROWS - 1, rel=0.03)


def test_a_model_that_is_not_fitted_still_has_a_constant() -> None:
    """The mean of a reference is never observable. Without effects in the model, a held model and a
    fitted model are the same, so that the same drift has the same gain in both: its squared part
    has a mean, which the constant takes away."""
    random = np.random.default_rng(43)
    rows = 400
    time_s = 10.0 * np.arange(rows)
    slow = (time_s / time_s[-1] - 0.5) ** 2
    loud = np.where((np.arange(rows) // 100) % 2 == 1, 4.0, 1.0)
    reference = Reference(
        target_deg=np.linspace(0.0, 360.0, rows, endpoint=False),
        error_arcsec=3.0 * slow + 0.2 * loud * random.normal(size=rows),
        time_s=time_s,
        run=np.zeros(rows, dtype=np.int64),
    )
    observations = observations_of(MeasurementSet(Table(), None, reference))
    fitted = fit([], observations, noise=white_noise(observations, (0.0, 0.2)))
    drift = built_in()["reference_drift"](degree=2)
    both = []
    for solution in (fitted, replace(fitted, held=True)):
        base = Residuals(solution)
        score = base.score(drift, {})
        both.append(gains_at_its_level(base, drift, {}, score, takes_most=False))
    assert len(both[0]) == 4
    assert [one.gain for one in both[1]] == pytest.approx([one.gain for one in both[0]], rel=1e-6)
