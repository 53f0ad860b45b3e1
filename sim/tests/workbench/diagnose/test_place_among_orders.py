"""Tests that the diagnosis states a single station that is off where the orders of the model
contain the errors of all stations."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.place_among_orders import place_among_orders
from arctrue.workbench.inference.repeated_error import RepeatedError
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of

Float = NDArray[np.float64]
STATIONS = 20
PASSES = 4
SIGMA = 0.15
ANGLE = 2.0 * np.pi * np.arange(STATIONS) / STATIONS


def _set(off_arcsec: Float, seed: int) -> MeasurementSet:
    """Return passes over a table with orders 1 to 3; ``off_arcsec``: own error of each station."""
    curve = 14.0 * np.cos(ANGLE + 1.0) + 2.0 * np.sin(2.0 * ANGLE) + 0.8 * np.cos(3.0 * ANGLE)
    noise = np.random.default_rng(seed).normal(0.0, SIGMA, (PASSES, STATIONS))
    return MeasurementSet(
        Table(),
        None,
        Reference(
            target_deg=np.tile(np.degrees(ANGLE), PASSES),
            error_arcsec=(curve + off_arcsec + noise).ravel(),
            run=np.repeat(np.arange(PASSES), STATIONS),
            time_s=np.arange(PASSES * STATIONS) * 6.0,
        ),
    )


def _found(off_arcsec: Float, seed: int) -> RepeatedError | None:
    terms = [Term(built_in()["graduation_harmonics"](), {})]
    return place_among_orders(fit(terms, observations_of(_set(off_arcsec, seed))))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_one_station(seed: int) -> None:
    """A curve of the orders 1 to 5 leaves 9 of 20 degrees of freedom: u = 0.15″/√(4·9/20)."""
    off = np.zeros(STATIONS)
    off[13] = -1.6
    found = _found(off, seed)
    assert found is not None
    (spot,) = found.spots
    assert spot.angle_deg == pytest.approx(234.0)
    assert spot.sigma_arcsec == pytest.approx(0.112, rel=0.4)
    assert spot.size_arcsec == pytest.approx(-1.6, abs=4.0 * 0.112)


def test_the_diagnosis_states_it() -> None:
    off = np.zeros(STATIONS)
    off[4] = 1.6
    found = diagnosis_of(_set(off, 4))
    assert found.verdict in ("cannot_tell", "adequate")
    text = " ".join(sentences(found))
    assert "A single station is off in each of 4 passes: 72° by 1." in text
    assert "beyond a curve of the orders 1 to 5" in text
    assert found.probability["none"] <= 0.5


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_no_single_station(seed: int) -> None:
    """Nothing, one high order, the own error of each face, and several high orders."""
    random = np.random.default_rng([3, seed])
    several = sum(
        random.normal(0.0, 0.5) * np.cos(order * ANGLE + random.uniform(0.0, 6.0))
        for order in range(6, 10)
    )
    faces = random.normal(0.0, 0.6, STATIONS)
    one = np.cos(8.0 * ANGLE + float(seed))
    for off in (np.zeros(STATIONS), one, faces, np.asarray(several)):
        assert _found(off, seed) is None
