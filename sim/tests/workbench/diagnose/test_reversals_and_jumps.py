"""Tests that the diagnosis reports a reversal error as a separate detection if a jump prevents the
catalogue's effects from fitting it."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.diagnosis import diagnose
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.forward.record import record_of
from arctrue.workbench.inference.forward.reversal import Reversal, reversal_of
from arctrue.workbench.model.model import default_model
from arctrue.workbench.observations.build import observations_of
from tests.workbench.noisy_logs import ornstein_uhlenbeck

EFFECTS = built_in()
SWEEPS, ROWS = 7, 120
SWEEP_S = 20.0


def _sweeps(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return time, direction, place in turns, and noise of a servo that moves up and down by one
    turn."""
    random = np.random.default_rng(seed)
    one = (np.arange(ROWS) + 0.5) / ROWS
    place = np.concatenate([one if number % 2 == 0 else one[::-1] for number in range(SWEEPS)])
    direction = np.repeat([1.0 if number % 2 == 0 else -1.0 for number in range(SWEEPS)], ROWS)
    time_s = SWEEP_S / ROWS * np.arange(SWEEPS * ROWS)
    noise = 0.3 * ornstein_uhlenbeck(random, time_s, 1.0) + 0.1 * random.normal(size=time_s.size)
    return time_s, direction, place, noise


def _found(seed: int, reversal: float, jump: float) -> Reversal | None:
    time_s, direction, place, noise = _sweeps(seed)
    after = (time_s >= 61.0).astype(np.float64)
    error = 0.5 * reversal * direction + jump * after + noise
    phase = 2.0 * np.pi * np.outer(place, np.arange(1, 21))
    orders = np.hstack([np.cos(phase), np.sin(phase)])
    one = np.zeros(time_s.size, dtype=np.int64)
    record = record_of(time_s, time_s, one, error - error.mean(), orders, in_time=True)
    return reversal_of(record, direction, after[:, np.newaxis])


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_reversal_is_measured_with_a_jump(seed: int) -> None:
    found = _found(seed, 2.0, 3.0)
    assert found is not None
    # The standard uncertainty of (mean of upward readings − mean of downward readings), with
    # Ornstein–Uhlenbeck noise of 0.3″ and time constant 1 s over 140 s, is 2·0.3·√(2/140) = 0.07″.
    assert found.size_arcsec == pytest.approx(2.0, abs=4.0 * 0.07)
    assert found.passes == SWEEPS


def test_noise_alone_has_no_reversal() -> None:
    """Noise alone gives a reversal in fewer than 3 of 100 sets: with a false-alarm probability of
    0.1 % per set, three or more have a probability of 0.02 %."""
    assert sum(_found(seed, 0.0, 3.0) is not None for seed in range(100)) < 3


def _of_white_rows(seed: int, reversal: float) -> Reversal | None:
    """Return the reversal of four passes with white rows of 1″ whose means per pass happen to
    differ by exactly ``reversal``."""
    time_s, direction, _, _ = (values[: 4 * ROWS] for values in _sweeps(seed))
    rows = np.random.default_rng([47, seed]).normal(size=(4, ROWS))
    rows -= rows.mean(axis=1, keepdims=True)
    error = rows.ravel() + 0.5 * reversal * direction
    none = np.zeros((time_s.size, 0))
    one = np.zeros(time_s.size, dtype=np.int64)
    return reversal_of(record_of(time_s, time_s, one, error, none, in_time=True), direction, none)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_differences_that_came_out_equal_are_no_small_uncertainty(seed: int) -> None:
    """The rows allow a standard uncertainty of 2·1″/√480 = 0.091″ of the difference: 0.16″ is no
    detection, and 2″ has this uncertainty or more."""
    assert _of_white_rows(seed, 0.16) is None
    found = _of_white_rows(seed, 2.0)
    assert found is not None
    assert found.sigma_arcsec is not None
    # The estimate from 96 parts of the passes scatters by 1/√(2·96) = 7 %.
    assert found.sigma_arcsec > 0.8 * 0.091


def test_a_single_reversal_confirms_nothing() -> None:
    time_s, direction, _, noise = (values[: 2 * ROWS] for values in _sweeps(1))
    none = np.zeros((time_s.size, 0))
    one = np.zeros(time_s.size, dtype=np.int64)
    record = record_of(time_s, time_s, one, noise + direction, none, in_time=True)
    found = reversal_of(record, direction, none)
    assert found is not None
    assert not found.confirmed


def test_the_reversal_and_the_jump_are_said_by_size() -> None:
    """The diagnosis names no effect, and states the reversal error in degrees and the jump: the
    upward and downward readings differ by 2° and the set jumps by 3°."""
    time_s, direction, place, noise = _sweeps(4)
    degree = 3600.0
    error = degree * (direction + 3.0 * (time_s >= 61.0) + 0.3 * noise)
    reference = Reference(
        target_deg=360.0 * place,
        error_arcsec=error,
        time_s=time_s,
        direction=direction.astype(np.int64),
        run=np.repeat(np.arange(SWEEPS), ROWS),
    )
    measured = MeasurementSet(Table(), None, reference, title="servo")
    found = diagnose(observations_of(measured), default_model().terms(EFFECTS), EFFECTS)
    assert found.verdict == "unknown"
    data = diagnosis_data(found, [])["findings"]["reversal"]
    assert data["size_arcsec"] == pytest.approx(2.0 * degree, rel=0.1)
    said = " ".join(sentences(found))
    assert "p and down differ by 2" in said
    assert "something jumped at 61" in said


@pytest.mark.large
def test_a_reversal_that_differs_from_place_to_place_is_said_with_a_line() -> None:
    """The set has a reversal error of ±650″ that varies by half, twice per turn, and a sine of
    order 32 with 460″; the diagnosis must report the reversal even if it names the sine."""
    time_s, direction, place, noise = _sweeps(5)
    angle = 2.0 * np.pi * place
    error = 650.0 * direction * (1.0 + 0.5 * np.cos(2.0 * angle + 1.0))
    error += 460.0 * np.cos(32.0 * angle) + 100.0 * noise
    reference = Reference(
        target_deg=360.0 * place,
        error_arcsec=error,
        time_s=time_s,
        direction=direction.astype(np.int64),
        run=np.repeat(np.arange(SWEEPS), ROWS),
    )
    measured = MeasurementSet(Table(), None, reference, title="gear box")
    found = diagnose(observations_of(measured), default_model().terms(EFFECTS), EFFECTS)
    if found.named is not None and found.named.name == "hysteresis":
        return
    reversal = found.detections.reversal
    assert reversal is not None
    assert abs(reversal.size_arcsec) == pytest.approx(1300.0, rel=0.15)
    said = [text for text in sentences(found) if "up and down differ" in text.lower()]
    assert len(said) == 1


@pytest.mark.parametrize("error", [0.0, 1.5])
def test_an_error_without_scatter_has_no_reversal(error: float) -> None:
    time_s, direction, _, _ = _sweeps(1)
    one = np.zeros(time_s.size, dtype=np.int64)
    values = np.full(time_s.size, error)
    columns = np.ones((time_s.size, 1))
    record = record_of(time_s, time_s, one, values - values.mean(), columns, in_time=True)
    assert reversal_of(record, direction, np.zeros((time_s.size, 0))) is None
