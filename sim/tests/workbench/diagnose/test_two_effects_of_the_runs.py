"""Tests that the diagnosis finds two effects that only together explain the offsets of the runs of
a reference."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from tests.workbench.base_diagnosis import diagnosis_of

Float = NDArray[np.float64]

SPEEDS = np.array([60.0, -60.0, 180.0, -180.0, 360.0, -360.0])
"""Speed of each run, degrees per second."""
ROWS, TURNS, PAUSE_S = 400, 2, 1.0
"""Rows and turns of a run on the move, and the pause between two runs."""


def _ladder(
    latency_us: float, reversal_arcsec: float, seed: int, zero_arcsec: float = 0.0
) -> MeasurementSet:
    """Return runs at several speeds in both directions, with a delay, a reversal error of this half
    width, and zeros of the runs with this standard deviation. The noise of 4″ has the correlation
    1/3 from row to row."""
    random = np.random.default_rng(seed)
    step_deg = TURNS * 360.0 / ROWS
    target, time_s, now, place = [], [], 0.0, 0.0
    for speed in SPEEDS:
        way = np.arange(ROWS) * step_deg
        target.append(place + np.sign(speed) * way)
        time_s.append(now + way / abs(speed))
        now += TURNS * 360.0 / abs(speed) + PAUSE_S
        place += np.sign(speed) * TURNS * 360.0
    run = np.repeat(np.arange(SPEEDS.size), ROWS)
    angle = np.radians(np.concatenate(target))
    white = random.normal(0.0, 4.0 * np.sqrt(1.0 - 1.0 / 9.0), run.size)
    noise = np.zeros(run.size)
    for row in range(1, run.size):
        noise[row] = noise[row - 1] / 3.0 + white[row]
    late = -latency_us * 1e-6 * SPEEDS[run] * 3600.0
    disc = 30.0 * np.cos(angle + 0.4) + 8.0 * np.cos(2.0 * angle - 1.0)
    zero = random.normal(0.0, zero_arcsec, SPEEDS.size)[run]
    return MeasurementSet(
        Table(),
        None,
        Reference(
            np.degrees(angle),
            disc + late + reversal_arcsec * np.sign(SPEEDS[run]) + zero + noise,
            run=run,
            time_s=np.concatenate(time_s),
            direction=np.sign(SPEEDS[run]).astype(np.int64),
        ),
    )


def _loaded(per_nm: float, seed: int, zero_arcsec: float = 0.0) -> MeasurementSet:
    """Return eight runs over 36 stations, alternately up and down, with a reversal error whose half
    width is 2″ + ``per_nm`` · load, and zeros of the runs with this standard deviation; a reading
    has 1″ of noise."""
    random = np.random.default_rng(seed)
    load = np.array([15.0, 30.0, 30.0, 15.0, 0.0, 0.0, 0.0, 5.0])
    run = np.repeat(np.arange(load.size), 36)
    up = np.arange(36) * 10.0
    target = np.concatenate([up if number % 2 == 0 else up[::-1] for number in range(load.size)])
    direction = 1 - 2 * (run % 2)
    error = 5.0 * np.cos(np.radians(target)) + direction * (2.0 + per_nm * load[run])
    error = error + random.normal(0.0, zero_arcsec, load.size)[run]
    return MeasurementSet(
        Table(),
        None,
        Reference(
            target,
            error + random.normal(0.0, 1.0, run.size),
            run=run,
            time_s=5.0 * np.arange(run.size) + 35.0 * run,
            direction=direction,
            conditions={"load_nm": load[run]},
        ),
    )


@pytest.mark.large
def test_a_delay_and_a_reversal_error_on_a_ladder_of_speeds() -> None:
    """The delay of 50 µs causes offsets of 11 to 65″ and is the larger; the reversal error is 25″
    in each direction. The mean of 400 readings has u = 4″ · √2/√400 = 0.28″ (the sum of all
    correlations of the noise is 2), so that the delay has u = 0.28″/(√6 · 0.84″/µs) < 0.2 µs."""
    found = diagnosis_of(_ladder(50.0, 25.0, seed=3))
    assert found.named is not None
    assert found.named.name == "latency"
    assert found.named.parameters()["latency"].value == pytest.approx(50.0, abs=0.8)
    assert [item.name for item in found.further] == ["hysteresis"]
    said = " ".join(sentences(found))
    assert "which latency and hysteresis explain together" in said
    assert "own zero" not in said


def test_a_reversal_error_that_grows_with_a_load() -> None:
    found = diagnosis_of(_loaded(0.4, seed=4))
    assert found.effect_class == ["hysteresis"]
    said = " ".join(sentences(found))
    assert "direction × (load_nm − 10), reference only, 0.4″/N·m" in said
    assert "which hysteresis and direction × (load_nm − 10) explain together" in said
    # Half of the reversal error acts in each direction. The mean of 288 readings of 1″ has
    # u = 0.06″, its double is the reversal error.
    assert found.named is not None
    size = found.named.parameters()["reversal_error"].value
    assert size == pytest.approx(2.0 * (2.0 + 0.4 * 10.0), abs=0.5)


def test_direction_times_a_column_can_be_set() -> None:
    product = ProductOfParts(
        condition="direction", column="load_nm", column_zero=10.0, fixed_to="reference"
    )
    assert product.parts == ["direction", "load_nm", "reference"]
    again = ProductOfParts.of(product.condition, (), "reference")
    assert again.settings["condition"] == "direction"
    with pytest.raises(ValueError, match="only one of condition"):
        ProductOfParts(condition="speed", column="load_nm", fixed_to="reference")


def test_own_zeros_of_runs_at_several_speeds_are_no_pair_of_effects() -> None:
    found = diagnosis_of(_ladder(0.0, 0.0, seed=1, zero_arcsec=20.0))
    assert found.effect_class == []
    assert "each run has its own zero" in " ".join(sentences(found))


@pytest.mark.parametrize("seed", [1, 2])
def test_own_zeros_of_runs_under_loads_are_no_pair_of_effects(seed: int) -> None:
    assert diagnosis_of(_loaded(-0.2, seed, zero_arcsec=5.0)).effect_class == []
