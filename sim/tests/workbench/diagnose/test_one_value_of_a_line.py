"""Tests that the sentences on a line state one value of its order and period."""

from __future__ import annotations

import re

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.report import sentences

PERIOD_S, SPEED_DEG_S = 520.0, 0.0045


def _log(seed: int) -> MeasurementSet:
    """Return a log over 20° with a line of 8″, its second harmonic of 2.5″ and an even drift; both
    change the order that a fit of the first line alone gives."""
    random = np.random.default_rng([2, seed])
    time_s = np.arange(0.0, 4_500.0, 2.0)
    phase = 2.0 * np.pi * time_s / PERIOD_S
    error = 8.0 * np.cos(phase + 0.4) + 2.5 * np.cos(2.0 * phase - 1.0) - 14.0 * time_s / 3600.0
    reference = Reference(
        SPEED_DEG_S * time_s, error + random.normal(0.0, 1.0, time_s.size), time_s=time_s
    )
    return MeasurementSet(Table(), None, reference, title="mount")


@pytest.mark.parametrize("seed", [1, 2])
def test_a_line_has_one_order_and_one_period(seed: int) -> None:
    found = diagnosis_of(_log(seed))
    assert found.named is not None
    said = " ".join(sentences(found))
    order, period_s = (
        float(text)
        for text in re.findall(r"line in the reference run of ([\d.]+) .*? or ([\d.]+) s", said)[0]
    )
    fitted, sigma = re.findall(r"uncertainties: order ([\d.]+) ± ([\d.]+)", said)[0]
    # The values are equal to the last digit of the rounded uncertainty.
    assert order == pytest.approx(float(fitted), abs=0.1 * float(sigma))
    listed = re.findall(r"at [\d.]+ s, order ([\d.]+)\)", said)[0]
    assert float(listed) == pytest.approx(order, abs=0.2 * float(sigma))
    assert "A second periodic_error explains a further part. Add the first" in said
    assert abs(order - 360.0 / SPEED_DEG_S / PERIOD_S) < 4.0 * float(sigma)
    assert period_s == pytest.approx(360.0 / SPEED_DEG_S / order, rel=1e-4)
