"""Tests that the diagnosis makes no statement from a model that the rows do not determine."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose import undetermined as module_of_the_rule
from arctrue.workbench.diagnose.diagnosis import diagnose
from arctrue.workbench.diagnose.regular import detections_of
from arctrue.workbench.diagnose.undetermined import MOST_LEFT, undetermined
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()
ROWS = 512


def _half_a_turn() -> Solution:
    """Return a fit of the paper's model to half a turn: 300″ of order 1, 480″ of order 100, 20″ of
    noise."""
    target = np.arange(ROWS) * 180.0 / ROWS
    angle = np.radians(target)
    error = 300.0 * np.cos(angle + 1.0) + 480.0 * np.cos(100.0 * angle)
    error += np.random.default_rng(1).normal(0.0, 20.0, ROWS)
    reference = Reference(target_deg=target, error_arcsec=error)
    measured = MeasurementSet(Table(), None, reference, title="half a turn")
    return fit([Term(EFFECTS["graduation_harmonics"](), {})], observations_of(measured))


@pytest.mark.parametrize("factor", [0.9, 1.1])
def test_a_model_that_leaves_twice_the_measured_variance_is_not_determined(factor: float) -> None:
    solution = _half_a_turn()
    assert solution.observations.reference is not None
    measured = float(np.var(solution.observations.reference.measured_arcsec))
    left = solution.reference_residual_arcsec()
    assert left is not None
    assert undetermined(solution) is None
    # Change one coefficient until the variance of the residuals is ``factor`` times the limit.
    more = np.zeros(solution.coefficients.size)
    more[0] = 1.0
    wave = (
        left
        - replace(solution, coefficients=solution.coefficients + more).reference_residual_arcsec()
    )
    square, mixed = float(np.var(wave)), float(np.cov(left, wave, bias=True)[0, 1])
    short = factor * MOST_LEFT * measured - float(np.var(left))
    size = (mixed + np.sqrt(mixed**2 + square * short)) / square
    worse = replace(solution, coefficients=solution.coefficients + size * more)
    why = undetermined(worse)
    assert (why is not None) is (factor > 1.0)
    if why is not None:
        assert "over 180°" in why
        assert detections_of(worse, EFFECTS).empty


def test_the_verdict_is_then_cannot_tell(monkeypatch: pytest.MonkeyPatch) -> None:
    solution = _half_a_turn()
    monkeypatch.setattr(module_of_the_rule, "MOST_LEFT", 0.0)
    found = diagnose(solution.observations, solution.terms, EFFECTS)
    assert found.verdict == "cannot_tell"
    assert found.detections.empty
    assert found.next_measurement is not None
    assert "whole turns" in found.next_measurement
