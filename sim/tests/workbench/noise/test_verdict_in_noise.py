"""Tests that the diagnosis gives no name to noise which is not white, and that it names an effect
which exceeds this noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of
from sim.tests.workbench.small_sets import COUNTS_PER_REV, measurement_set

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.effects.registry import built_in

EFFECTS = built_in()
COUNT_ARCSEC = 1_296_000.0 / COUNTS_PER_REV


def _ornstein_uhlenbeck(rows: int, length: float, random: np.random.Generator) -> np.ndarray:
    decay = np.exp(-1.0 / length)
    steps = random.normal(size=rows) * np.sqrt(1.0 - decay**2)
    values = np.empty(rows)
    values[0] = random.normal()
    for row in range(1, rows):
        values[row] = decay * values[row - 1] + steps[row]
    return values


def _with_slow_capture(made: MeasurementSet, seed: int) -> MeasurementSet:
    """Return the set with 0.1″ of slow noise added to head 2; the noise has a correlation time of
    200 rows."""
    assert made.capture is not None
    random = np.random.default_rng(seed)
    counts = made.capture.head2_counts.astype(np.float64)
    for run in np.unique(made.capture.run):
        inside = made.capture.run == run
        wander = _ornstein_uhlenbeck(int(inside.sum()), 200.0, random)
        counts[inside] += 0.1 / COUNT_ARCSEC * wander
    capture = replace(made.capture, head2_counts=np.round(counts).astype(np.int64))
    return replace(made, capture=capture)


def _with_wandering_reference(made: MeasurementSet, seed: int) -> MeasurementSet:
    """Return the set with 0.3″ of slow noise added to the reference; the noise has a correlation
    time of 45 stations, which are three minutes at 4 s each."""
    assert made.reference is not None
    error = made.reference.error_arcsec
    wander = 0.3 * _ornstein_uhlenbeck(error.size, 45.0, np.random.default_rng(seed))
    return replace(made, reference=replace(made.reference, error_arcsec=error + wander))


@pytest.mark.large
@pytest.mark.parametrize("seed", [1, 2])
def test_slow_noise_of_a_head_gets_no_name(seed: int) -> None:
    """The diagnosis gives no name to the slow noise of a head. In an earlier version, the noise was
    modelled as white noise of the same size, and every such set led to a slip, a drift or a
    vibration."""
    assert diagnosis_of(_with_slow_capture(measurement_set(seed=seed), seed)).verdict == "adequate"


@pytest.mark.large
@pytest.mark.parametrize("seed", [1, 2])
def test_a_wandering_reference_gets_no_name(seed: int) -> None:
    made = _with_wandering_reference(measurement_set(seed=seed, cycles=10), seed)
    assert diagnosis_of(made).verdict == "adequate"


@pytest.mark.large
def test_a_reversal_stands_out_of_a_wandering_reference() -> None:
    """The diagnosis names the reversal error although a pass over 24 stations takes half of the
    correlation time of the noise."""
    made = measurement_set(reversal_arcsec=0.8, cycles=10)
    result = diagnosis_of(_with_wandering_reference(made, 3))
    assert result.named is not None
    assert result.named.name == "hysteresis"


@pytest.mark.large
def test_a_slip_is_not_taken_for_slow_noise() -> None:
    """The diagnosis names a slip if 2,100 of the 3,600 rows of a run lie 12 counts higher. Slow
    noise that is estimated without the slip would also explain these rows."""
    made = _with_slow_capture(measurement_set(), 5)
    assert made.capture is not None
    run = made.capture.run
    made.capture.head2_counts[np.flatnonzero(run == 1)[1500:]] += 12
    result = diagnosis_of(made)
    assert result.named is not None
    assert result.named.name == "count_slip"


def test_one_polygon_cycle_alone_cannot_tell() -> None:
    """The diagnosis cannot decide from 24 rows of a polygon alone: 41 coefficients leave no
    residual. In an earlier version it estimated a noise of 0 and therefore named a bearing
    motion."""
    made = measurement_set(cycles=1)
    assert made.reference is not None
    first = {
        name: value[:24] if isinstance(value, np.ndarray) else value
        for name, value in vars(made.reference).items()
    }
    alone = replace(made, capture=None, reference=type(made.reference)(**first))
    result = diagnosis_of(alone)
    assert result.verdict == "cannot_tell"
    assert result.next_measurement is not None


def _gusts(seed: int) -> MeasurementSet:
    """Return an antenna's log of 50 minutes and four turns: slow noise of 4″ and 80 s, three times
    larger in gusts."""
    random = np.random.default_rng(seed)
    time_s = 2.0 * np.arange(1500)
    noise = 4.0 * _ornstein_uhlenbeck(time_s.size, 40.0, random)
    noise *= np.where(np.sin(time_s / 260.0) > 0.5, 3.0, 1.0)
    reference = Reference(
        target_deg=0.5 * time_s,
        error_arcsec=noise,
        time_s=time_s,
        run=np.zeros(time_s.size, dtype=np.int64),
    )
    return MeasurementSet(Table(), None, reference)


@pytest.mark.large
@pytest.mark.parametrize("seed", [1, 5])
def test_gusts_are_no_drift(seed: int) -> None:
    """Gusts get no name: in each turn other parts are loud, so that the parts of the turn have no
    scale. In an earlier version, four of the seeds 1 to 7 gave a drift with p < 0.01."""
    found = diagnosis_of(_gusts(seed))
    assert found.verdict in ("adequate", "cannot_tell")
