"""Tests that coefficients which no row determines affect neither a likelihood nor a verdict."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.numeric.symmetric import log_determinant

STATIONS, COEFFICIENTS = 9, 41


@pytest.mark.parametrize("factor", [1.0, 7.0, 1e4])
def test_a_determinant_grows_with_the_directions_that_are_determined(factor: float) -> None:
    """The determinant of the normal matrix N is the product of the eigenvalues above the rounding
    error only. With 41 columns at 9 stations nine eigenvalues remain, so that |N/σ²| = |N|·σ⁻¹⁸."""
    columns = np.random.default_rng(4).normal(size=(STATIONS, COEFFICIENTS))
    columns *= np.geomspace(0.1, 30.0, COEFFICIENTS)
    normal = columns.T @ columns
    expected = np.sum(np.log(np.linalg.svd(columns)[1] ** 2)) + STATIONS * np.log(factor)
    assert log_determinant(factor * normal) == pytest.approx(expected, abs=1e-6)


def test_the_determinant_of_a_full_rank_is_the_usual_one() -> None:
    columns = np.random.default_rng(5).normal(size=(60, 12)) * np.geomspace(1e-4, 1e3, 12)
    normal = columns.T @ columns
    assert log_determinant(normal) == pytest.approx(np.linalg.slogdet(normal)[1], abs=1e-6)


@pytest.mark.parametrize(("reversal_arcsec", "first"), [(1.8, "hysteresis"), (0.0, None)])
def test_nine_stations_up_and_down_once_show_a_reversal(
    reversal_arcsec: float, first: str | None
) -> None:
    """Nine stations, visited up and down once, show a reversal error of 1.8″, and no reversal error
    in a table without one. Nine differences of 1.8″ with a scatter of 0.18″ give t = 30 with 8
    degrees of freedom.

    With a single reversal, a change over time may look like the reversal error, so that the
    diagnosis may name a class of several effects, of which hysteresis is the first.
    """
    random = np.random.default_rng(7)
    up = np.arange(STATIONS) * 360.0 / STATIONS
    target = np.concatenate([up, up[::-1]])
    direction = np.repeat([1, -1], STATIONS)
    error = 90.0 * np.cos(np.radians(target) + 0.4) + random.normal(0.0, 0.13, target.size)
    reference = Reference(
        target_deg=target,
        error_arcsec=error + np.where(direction > 0, 0.0, reversal_arcsec),
        time_s=10.0 * np.arange(target.size),
        run=np.repeat([0, 1], STATIONS),
        direction=direction,
    )
    found = diagnosis_of(MeasurementSet(Table(), None, reference, title="few stations"))
    assert (found.effect_class[0] if found.effect_class else None) == first
