"""Tests that a description by one condition names another condition that fits as well.

The sets are computed in this module, with plain numpy."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of

from arctrue.measurement import Capture, MeasurementSet, Reference, Table
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


COUNTS = 1 << 24


def _ripple_of_a_motor(seed: int) -> MeasurementSet:
    """Return runs of 1.3 turns at ±10 and ±40 °/s, in which head 1 has an error of order 12 of
    0.1″ at 10 °/s and 0.4″ at 40 °/s; each head has 0.1″ of noise."""
    random = np.random.default_rng(seed)
    rows, runs, times, heads = 800, [], [], []
    for number, speed in enumerate([10.0, -10.0, 40.0, -40.0]):
        since = np.linspace(0.0, 1.3 * 360.0 / abs(speed), rows, endpoint=False)
        angle = 25.0 * number + speed * since
        ripple = 0.01 * abs(speed) * np.sin(12.0 * np.radians(angle) + 0.3)
        readings = [
            3600.0 * place + 30.0 * np.cos(np.radians(place)) + random.normal(0.0, 0.1, rows)
            for place in (angle, angle + 33.0)
        ]
        readings[0] += ripple
        runs.append(np.full(rows, number))
        times.append(200.0 * number + since)
        heads.append([np.rint(item / 1_296_000.0 * COUNTS).astype(np.int64) for item in readings])
    capture = Capture(
        run=np.concatenate(runs),
        time_s=np.concatenate(times),
        head1_counts=np.concatenate([item[0] for item in heads]),
        head2_counts=np.concatenate([item[1] for item in heads]),
    )
    table = Table(counts_per_rev=COUNTS, grating_lines=16_384, head_separation_deg=33.0)
    return MeasurementSet(table, capture, None, title="ripple of a motor")


def test_two_speeds_do_not_separate_the_speed_from_its_square() -> None:
    found = diagnosis_of(_ripple_of_a_motor(1))
    assert found.verdict == "unknown"
    assert {"speed²", "|speed|"} == {
        item.effect.condition.words for item in (found.described, *found.equals)
    }
    assert found.next_measurement is not None
    assert "a value of the speed that this set does not have" in found.next_measurement
