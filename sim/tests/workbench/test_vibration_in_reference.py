"""Tests that the diagnosis finds a vibration of head 1's bracket also in the reference, at the
alias of its frequency."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sim.tests.workbench.small_sets import REFERENCE_NOISE, measurement_set

from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.search import places_of
from arctrue.workbench.inference.search_parameters import refined
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()
FREQUENCY_HZ = 7.31
"""Frequency of the vibration, which appears as a line of 0.06 Hz in readings every 4 s."""
SIZE_ARCSEC = 0.5


def _fitted(*, head1: bool, in_time: bool = True) -> Solution:
    made = measurement_set(
        head2_only=lambda time, _: -SIZE_ARCSEC * np.cos(2.0 * np.pi * FREQUENCY_HZ * time)
    )
    assert made.reference is not None
    assert made.reference.time_s is not None
    phase = 2.0 * np.pi * FREQUENCY_HZ * made.reference.time_s + 0.7
    made.reference.error_arcsec[:] += head1 * SIZE_ARCSEC * np.cos(phase)
    if not in_time:
        made = replace(made, reference=replace(made.reference, time_s=None))
    observations = observations_of(made)
    graduation = Term(EFFECTS["graduation_harmonics"](), {})
    effect = EFFECTS["vibration"]()
    place = places_of(effect, Residuals(fit([graduation], observations)))[0]
    return refined(fit([graduation, Term(effect, place.nonlinear)], observations))


def test_nothing_of_it_is_left_in_the_reference() -> None:
    """No part of the vibration remains in the reference. In an earlier version the whole vibration
    remained there, and the diagnosis reported it as a line without a cause."""
    solution = _fitted(head1=True)
    left = solution.reference_residual_arcsec()
    assert left is not None
    # 288 rows with at most 23 coefficients determine the scatter to 5 %; the tolerance is 15 %.
    assert float(np.std(left)) == pytest.approx(REFERENCE_NOISE, rel=0.15)
    # The frequency of a sine in white noise has σ = √(6/n)·(noise/amplitude)/(π·T) with T = 1,152
    # s; the tolerance is five times σ.
    sigma_hz = np.sqrt(6.0 / 288) * (REFERENCE_NOISE / SIZE_ARCSEC) / (np.pi * 1152.0)
    found = solution.terms[-1].nonlinear["frequency"]
    assert found == pytest.approx(FREQUENCY_HZ, abs=5.0 * sigma_hz)


@pytest.mark.large
def test_a_bracket_of_head_2_leaves_the_reference_alone() -> None:
    solution = _fitted(head1=False)
    reported = solution.terms[-1].effect.parameters(
        solution.coefficients[solution.part(1)],
        solution.covariance[solution.part(1), solution.part(1)],
        solution.terms[-1].nonlinear,
        solution.observations,
    )
    size = reported["reference_amplitude"]
    assert size.value < 4.0 * size.sigma
    # In 14,400 rows of R₂ − R₁ the uncertainty of the amplitude is √(2/n) times the noise of two
    # heads; the tolerance is five times this.
    assert reported["amplitude"].value == pytest.approx(
        SIZE_ARCSEC, abs=5.0 * 0.15 * np.sqrt(2 / 14_400)
    )


@pytest.mark.large
def test_columns_of_a_run_act_in_that_run_alone() -> None:
    """``column_runs`` names the runs in which a column has capture rows that are not zero."""
    solution = _fitted(head1=True)
    vibration, rows = solution.terms[-1].effect, solution.observations.capture
    assert rows is not None
    columns = vibration.capture_columns(rows, solution.terms[-1].nonlinear, solution.context)
    acting = [set(rows.run[column != 0.0].tolist()) for column in columns.T]
    runs = vibration.column_runs(solution.observations)
    assert acting == [set() if run is None else {run} for run in runs]
    assert None in runs, "those of the reference belong to no run"


@pytest.mark.large
def test_a_reference_without_times_has_no_columns_of_it() -> None:
    solution = _fitted(head1=False, in_time=False)
    assert solution.widths[1] == 2 * 4
