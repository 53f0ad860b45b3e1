"""Tests that the charts of ``arctrue calibrate`` and ``arctrue diagnose`` draw the figures of their
data."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.scale import SymmetricalLogTransform
from sim.tests.workbench.small_sets import measurement_set, paper_error

from arctrue.calibration.calibration import Calibration, CalibrationSettings, calibrate
from arctrue.report.charts.calibration_chart import calibration_chart
from arctrue.report.charts.candidates import LINEAR_TO, along
from arctrue.report.charts.chart import Bars, Curve


@pytest.fixture(scope="module")
def calibration() -> Calibration:
    return calibrate(measurement_set(paper_error), CalibrationSettings())


def test_bars_are_the_amplitudes_of_the_orders(calibration: Calibration) -> None:
    bars = [
        layer
        for layer in calibration_chart(calibration, "").panels[-1].layers
        if isinstance(layer, Bars)
    ]
    drawn = {
        int(n): bar.base + y for bar in bars for n, y in zip(bar.place, bar.length, strict=True)
    }
    for order, verdict in zip(calibration.estimate.orders, calibration.verdicts, strict=True):
        if verdict.applied:
            index = int(np.flatnonzero(calibration.estimate.orders == order)[0])
            assert drawn[int(order)] == pytest.approx(calibration.estimate.amplitude_arcsec[index])
    applied = {verdict.order for verdict in calibration.verdicts if verdict.applied}
    assert applied == {int(n) for bar in bars if bar.name == "applied" for n in bar.place}


def test_the_reference_run_stands_on_the_curve_of_the_two_heads(calibration: Calibration) -> None:
    curve, run = (
        x for x in calibration_chart(calibration, "").panels[0].layers if isinstance(x, Curve)
    )
    # The reference has some hundreds of rows with 0.15″ of noise; the limit is five standard
    # deviations of this noise.
    left = run.y - np.interp(run.x, curve.x, curve.y)
    assert np.abs(left - left.mean()).max() < 5.0 * 0.15


def test_places_of_delta_bic_are_those_of_a_symmetric_logarithm() -> None:
    """The chart places ΔBIC where matplotlib's symmetric logarithmic scale places it, if the linear
    part of the scale is one decade wide per side."""
    value = np.array([-3e4, -100.0, -10.0, -9.0, 0.0, 0.5, 10.0, 11.0, 1e5])
    theirs = SymmetricalLogTransform(10.0, LINEAR_TO, 0.9).transform_non_affine(value)
    np.testing.assert_allclose(along(value), theirs / LINEAR_TO, rtol=1e-12)
