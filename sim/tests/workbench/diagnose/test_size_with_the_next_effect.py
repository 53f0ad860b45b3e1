"""Tests that the stated size of an effect is that of the model with the further effects."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.report import sentences

DELAY_US = 5_000.0
REVERSAL_ARCSEC = 1.0


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_delay_has_its_size_although_a_reversal_error_is_found_after_it(seed: int) -> None:
    """Eight turns at 2 to 16°/s, up and down, have a delay of 5 ms and ±1″ with the direction.

    Both change their sign with the direction, so that the delay alone explains a part of the
    reversal error: 1″·Σ|v|/Σv² = 1″·30/340 s/°, 25 µs, many times its uncertainty.
    """
    rng = np.random.default_rng(seed)
    columns = []
    start = 0.0
    for run, speed in enumerate(way * size for size in (2, 4, 8, 16) for way in (1, -1)):
        since = np.arange(0.0, 360.0 / abs(speed), 0.25)
        target = np.mod(speed * since, 360.0)
        error = 20.0 * np.cos(np.radians(target) + 1.0) + 3.0 * np.cos(np.radians(3.0 * target))
        error += REVERSAL_ARCSEC * np.sign(speed) - 3600.0e-6 * DELAY_US * speed
        size = np.ones(since.size)
        columns.append((run * size, start + since, np.sign(speed) * size, target, error))
        start += since[-1] + 20.0
    run, time, direction, target, error = (
        np.concatenate(one) for one in zip(*columns, strict=True)
    )
    reference = Reference(
        target_deg=target,
        error_arcsec=error + rng.normal(0.0, 0.3, error.size),
        run=run.astype(np.int64),
        time_s=time,
        direction=direction.astype(np.int64),
    )
    found = diagnosis_of(MeasurementSet(title="", table=Table(), reference=reference))
    assert found.named is not None
    assert [found.named.name, *(item.name for item in found.further)] == ["latency", "hysteresis"]
    delay = found.named.parameters()["latency"]
    # 4 standard uncertainties fail once in 16,000 sets.
    assert abs(delay.value - DELAY_US) < 4.0 * delay.sigma
    assert delay.sigma < 2.0
    alone = found.named.solution.parameters()[-1]["latency"]
    assert abs(alone.value - DELAY_US) > 10.0
    assert f"latency {delay.value:.2f} ± " in " ".join(sentences(found))
