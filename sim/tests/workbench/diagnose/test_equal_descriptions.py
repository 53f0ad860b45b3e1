"""Tests that a description by one condition names another condition that fits as well.

The sets are computed in this module, with plain numpy."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.report import sentences


def _joint(loads_nm: list[float], seed: int) -> MeasurementSet:
    """Return runs over a turn, up and down in turn, with a load each; friction shifts the reading
    by 0.6″ × direction for each N·m. A run takes 60 s, and one begins every 120 s."""
    random = np.random.default_rng(seed)
    rows = 120
    run = np.repeat(np.arange(len(loads_nm)), rows)
    direction = np.where(run % 2 == 0, 1, -1)
    up = np.tile(np.linspace(0.0, 357.0, rows), len(loads_nm))
    angle = np.where(direction > 0, up, 357.0 - up)
    load = np.array(loads_nm)[run]
    error = 0.6 * direction * load + 7.0 * np.cos(np.radians(angle + 30.0))
    error += random.normal(0.0, 1.0, run.size)
    reference = Reference(
        angle,
        error,
        run=run,
        time_s=120.0 * run + np.tile(np.linspace(0.0, 60.0, rows), len(loads_nm)),
        direction=direction,
        conditions={"load_nm": load + random.normal(0.0, 0.05, run.size)},
    )
    return MeasurementSet(Table(), None, reference, title="joint")


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_load_that_rises_with_the_time_is_named_with_it(seed: int) -> None:
    """The load rises after every second run, so that direction × load and direction × time, scaled,
    differ only by a constant within the runs of one direction."""
    found = diagnosis_of(_joint([0.0, 0.0, 8.0, 8.0, 16.0, 16.0, 24.0, 24.0], seed))
    said = " ".join(sentences(found))
    assert found.verdict == "unknown"
    assert "direction × time" in said
    # Up and down, the reading changes by ±0.6″ for each N·m; u is far below 0.02″/N·m.
    assert "describes the error equally well: direction × (load_nm − 1" in said
    assert found.equal is not None
    (size,) = found.equal.parameters().values()
    assert size.value == pytest.approx(0.6, abs=0.02)
    assert found.next_measurement is not None
    assert "load_nm in another order" in found.next_measurement


def test_a_load_in_mixed_order_has_no_equal() -> None:
    found = diagnosis_of(_joint([16.0, 16.0, 0.0, 0.0, 24.0, 24.0, 8.0, 8.0], 4))
    said = " ".join(sentences(found))
    assert "load_nm" in said
    assert "equally well" not in said
