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
    (equal,) = found.equals
    (size,) = equal.parameters().values()
    assert size.value == pytest.approx(0.6, abs=0.02)
    assert found.next_measurement is not None
    assert "load_nm in another order" in found.next_measurement


def test_a_load_in_mixed_order_has_no_equal() -> None:
    found = diagnosis_of(_joint([16.0, 16.0, 0.0, 0.0, 24.0, 24.0, 8.0, 8.0], 4))
    said = " ".join(sentences(found))
    assert "load_nm" in said
    assert "equally well" not in said


STATIONS, PASSES = 30, 5


def _all_together(seed: int) -> MeasurementSet:
    """Return passes over 30 stations in one direction, while load, temperature and time rise
    together (correlation above 0.999); the reading shifts by 0.08″ for each N·m."""
    random = np.random.default_rng(seed)
    rows = STATIONS * PASSES
    angle = np.tile(np.arange(STATIONS) * 360.0 / STATIONS, PASSES)
    time_s = 15.0 * np.arange(rows)
    share = time_s / time_s[-1]
    load = 5.0 + 30.0 * share + random.normal(0.0, 0.15, rows)
    error = 6.0 * np.cos(np.radians(angle + 30.0)) + 1.1 * np.cos(2.0 * np.radians(angle))
    error += 0.08 * load + random.normal(0.0, 0.2, rows)
    reference = Reference(
        angle,
        error,
        time_s=time_s,
        cycle=np.repeat(np.arange(PASSES), STATIONS),
        direction=np.ones(rows, dtype=np.int64),
        temperature_c=20.0 + 2.5 * share + random.normal(0.0, 0.012, rows),
        conditions={"load_nm": load},
    )
    return MeasurementSet(Table(), None, reference, title="all together")


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_every_condition_that_changed_together_is_stated(seed: int) -> None:
    """In each pass the drift is the same ramp over the angle; this ramp does not belong to the
    place."""
    found = diagnosis_of(_all_together(seed))
    said = " ".join(sentences(found))
    assert found.verdict == "ambiguous"
    assert found.effect_class == ["reference_drift"]
    assert "(T − T₀), reference only" in said
    # 0.08″/N·m, with u = 0.2″/√150/8.7 N·m, which is 0.002.
    size = float(said.split("(load_nm − ")[1].split("reference only, ")[1].split("″")[0])
    assert size == pytest.approx(0.08, abs=0.008)
    assert found.next_measurement is not None
    assert "load_nm in another order" in found.next_measurement
    assert "repeats at equal angle" not in said
