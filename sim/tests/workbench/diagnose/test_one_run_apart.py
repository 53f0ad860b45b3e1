"""Tests that a drift of a head in the only warm run of four is found, and that the scatter of an
index from run to run is not taken for a drift."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.small_sets import COUNTS_PER_REV, measurement_set

COUNT_ARCSEC = 1_296_000.0 / COUNTS_PER_REV


def _four_runs(warm_arcsec: float, seed: int, scatter_counts: float = 0.5) -> MeasurementSet:
    """Return a set with runs at 20, 20, 20 and 24 °C. Head 2 begins each run with a random offset
    of ``scatter_counts`` (RMS), and moves by ``warm_arcsec`` in the warm run."""
    measured = measurement_set(seed=seed, reference=False)
    capture = measured.capture
    assert capture is not None
    assert capture.run is not None
    random = np.random.default_rng((17, seed))
    index = np.round(scatter_counts * random.normal(size=4))
    warm = np.where(capture.run == 3, warm_arcsec / COUNT_ARCSEC, 0.0)
    moved = np.round(capture.head2_counts + index[capture.run] + warm).astype(np.int64)
    # The temperature sensor scatters by 5 mK; the drift does not follow this scatter.
    temperature = np.where(capture.run == 3, 24.0, 20.0) + 0.005 * random.normal(size=moved.size)
    return replace(
        measured, capture=replace(capture, head2_counts=moved, temperature_c=temperature)
    )


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.large)])
@pytest.mark.parametrize("warm_arcsec", [3.4, pytest.param(-2.0, marks=pytest.mark.large)])
def test_a_drift_in_the_one_warm_run_is_found(warm_arcsec: float, seed: int) -> None:
    """The diagnosis finds the drift of head 2, which moves by 25 counts or more in the warm run,
    while the offsets of the four runs scatter by half a count."""
    found = diagnosis_of(_four_runs(warm_arcsec, seed))
    assert found.effect_class[0] == "thermal_head_drift"


@pytest.mark.large
@pytest.mark.parametrize("seed", [3, 4, 5])
def test_an_index_that_scatters_is_no_drift(seed: int) -> None:
    """The diagnosis finds no drift if head 2 begins each run at a random place, with a standard
    deviation of 20 counts."""
    found = diagnosis_of(_four_runs(0.0, seed, scatter_counts=20.0))
    assert "thermal_head_drift" not in found.effect_class
