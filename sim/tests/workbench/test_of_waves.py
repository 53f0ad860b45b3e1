"""Tests effects whose capture columns are combinations of waves that other effects have too."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.workbench.effects.base import Effect, FitContext
from arctrue.workbench.effects.catalogue.radial_error_motion import RadialErrorMotion
from arctrue.workbench.effects.part_conditions import conditions
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.model.model import default_model
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of
from tests.workbench.small_sets import measurement_set


def _forms(observations: Observations) -> list[Effect]:
    forms: list[Effect] = [RadialErrorMotion(orders=[2, 5]), RadialErrorMotion(orders=[5, 7])]
    for condition in conditions(observations):
        forms += [
            ProductOfParts.of(condition, (), "head2"),
            ProductOfParts.of(condition, (), "head1"),
        ]
        forms += [
            ProductOfParts.of(condition, (order,), frame)
            for order in (1.5, 2.0)
            for frame in ("stator", "head1", "head2", "disc")
        ]
    return forms


def test_combinations_of_waves_are_the_columns() -> None:
    """The bound is far above the rounding of a few operations in float64: 1e-12 of the largest
    column."""
    observations = observations_of(measurement_set())
    rows = observations.capture
    assert rows is not None
    shared = 0
    for form in _forms(observations):
        of_waves = form.of_waves(rows)
        columns = form.capture_columns(rows, {}, FitContext())
        if of_waves is None or columns is None:
            continue
        waves = [wave.columns() for wave in of_waves.waves]
        assert [wave.shape[1] for wave in waves] == [wave.width for wave in of_waves.waves]
        away = np.abs(np.hstack(waves) @ of_waves.factors - columns).max()
        assert away < 1e-12 * float(np.abs(columns).max(initial=1.0))
        shared += 1
    assert shared > 10


@pytest.mark.large
def test_effects_scored_together_get_the_scores_of_their_own_columns(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The bound follows from a direction at the limit of the rank: with the condition 3e4 it loses
    9 of float64's 16 digits."""
    observations = observations_of(measurement_set())
    solution = fit(default_model().terms(built_in()), observations)
    forms = _forms(observations)
    together = Residuals(solution).scores([(form, {}) for form in forms])
    for kind in (RadialErrorMotion, ProductOfParts):
        monkeypatch.setattr(kind, "of_waves", Effect.of_waves)
    alone = Residuals(solution)
    for form, score in zip(forms, together, strict=True):
        expected = alone.score(form, {})
        assert score.rank == expected.rank
        assert score.gain == pytest.approx(expected.gain, rel=1e-6, abs=1e-6)
