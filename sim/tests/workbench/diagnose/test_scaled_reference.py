"""Tests that a reference in another unit than arcseconds is a fault if two heads show it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of
from sim.tests.workbench.small_sets import measurement_set

from arctrue.measurement import MeasurementSet
from arctrue.workbench.diagnose.data_faults import data_faults
from arctrue.workbench.observations.build import observations_of


def _scaled(factor: float, *, seed: int = 1, u_arcsec: float | None = 0.2) -> MeasurementSet:
    """Return a set with the errors of the reference, 90″ of order 1 and up to 0.8″ of further
    orders, times ``factor``."""
    made = measurement_set(seed=seed, turns=1, cycles=3)
    assert made.reference is not None
    reference = replace(
        made.reference,
        error_arcsec=made.reference.error_arcsec * factor,
        standard_uncertainty_arcsec=u_arcsec,
    )
    return replace(made, reference=reference)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize(
    ("unit_arcsec", "unit"), [(60.0, "arcminutes"), (3600.0, "degrees"), (206_264.8, "radians")]
)
def test_a_reference_in_another_unit_is_a_fault(unit_arcsec: float, unit: str, seed: int) -> None:
    (said,) = data_faults(observations_of(_scaled(1.0 / unit_arcsec, seed=seed)))
    assert f"they seem to be in {unit};" in said
    # The noise of 0.15″ in 144 rows gives a relative u of 0.15/√144/64, which is 0.0002.
    factor = float(said.split("errors are ")[1].split(" times")[0])
    assert factor * unit_arcsec == pytest.approx(1.0, abs=0.001)


def test_degrees_are_a_fault_without_a_stated_uncertainty() -> None:
    (said,) = data_faults(observations_of(_scaled(-1.0 / 3600.0, u_arcsec=None)))
    assert "in degrees, with the other sign" in said
    assert diagnosis_of(_scaled(-1.0 / 3600.0, u_arcsec=None)).verdict == "bad_data"


@pytest.mark.parametrize("factor", [1.0, 1.1, -1.0, 1.0 / 30.0, 1.0 / 100.0])
def test_a_gain_is_no_unit(factor: float) -> None:
    assert data_faults(observations_of(_scaled(factor))) == []


@pytest.mark.parametrize("share", [60.0, 3600.0])
def test_a_remainder_of_the_shape_of_the_disc_is_no_unit(share: float) -> None:
    """A reference measures the corrected angle, of which 1/60 or less of the disc's error is left,
    with 0.02″ of noise."""
    made = _scaled(1.0 / share, u_arcsec=0.02)
    assert made.reference is not None
    made.reference.error_arcsec[:] += np.random.default_rng(4).normal(0.0, 0.02, 144)
    assert data_faults(observations_of(made)) == []
