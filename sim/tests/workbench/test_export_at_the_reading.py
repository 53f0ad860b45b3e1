"""Tests that the export converts high orders of the true angle to the reading, and that the stated
remaining error is that of the bit-true gateware."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.calibration.comparison import compare, extent
from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.effects.registry import catalogue
from arctrue.workbench.model.export import export_model
from arctrue.workbench.model.growth import fitted
from arctrue.workbench.model.model import ModelEffect, default_model
from arctrue.workbench.model.taken_away import outcome
from arctrue.workbench.observations.build import observations_of

COUNTS = 1 << 24
NOISE = 0.02
TEETH = 180


@pytest.mark.parametrize("lanes", [16, 2])
def test_the_stated_remainder_is_that_of_the_gateware(lanes: int) -> None:
    """A worm's error of 10″ at 180 periods a turn has sidebands of 180 · 100″ · 10″ / 2 in the
    reading, because the reading differs from the true angle by an eccentricity of 100″.

    With 2 lanes no lane is left for a sideband, and the stated remainder contains the sidebands.
    The bound of 5 % is 4 standard deviations of an RMS of 3,600 rows.
    """
    random, target = np.random.default_rng(0), np.arange(3600) * 0.1
    angle = np.radians(target)
    noise = NOISE * random.standard_normal(target.size)
    error = 100.0 * np.cos(angle) + 10.0 * np.cos(TEETH * angle) + noise
    counts = np.rint((target + error / 3600.0) / 360.0 * COUNTS).astype(np.int64)
    reference = Reference(
        target, error, head1_counts=counts, standard_uncertainty_arcsec=NOISE, instrument="polygon"
    )
    table = Table(counts_per_rev=COUNTS, drive_gear_teeth=float(TEETH))
    observations = observations_of(
        MeasurementSet(table, reference=reference, title="worm"), mask_outliers=False
    )
    effects = [
        ModelEffect("graduation_harmonics", {"orders": [1, 2]}),
        ModelEffect("drive_gear_error"),
    ]
    known = catalogue()
    model, _ = fitted(replace(default_model(), effects=effects), observations, known)
    found = export_model(model, observations, known, lanes=lanes, temperature_c=None)
    sideband = 0.5 * TEETH * 100.0 * 10.0 * np.pi / 648_000.0
    sizes = dict(zip(found.orders, found.amplitudes_arcsec, strict=True))
    with_sidebands = lanes > 2
    if with_sidebands:
        assert sizes[TEETH - 1] == pytest.approx(sideband, rel=0.02)
        assert sizes[TEETH + 1] == pytest.approx(sideband, rel=0.02)
    became = outcome(model, observations, known, found.coefficients, temperature_c=None)
    after = extent(compare(reference, found.coefficients).after_arcsec).rms
    count = 1_296_000 / COUNTS
    # Noise and rounding of the correction belong to the comparison, not to the model.
    of_model = np.sqrt(after**2 - NOISE**2 - count**2 / 12.0)
    assert became.left_arcsec == pytest.approx(of_model, rel=0.05, abs=0.003)
    expected = 0.0 if with_sidebands else sideband
    assert became.left_arcsec == pytest.approx(expected, abs=0.08)
