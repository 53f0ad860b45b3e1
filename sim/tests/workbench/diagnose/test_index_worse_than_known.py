"""Tests that the diagnosis names no effect for run offsets that scatter more than the index should.

The offsets scatter by ±20 counts, as if the index mark were detected to ±1.5″; the prior of an
index is ±1 count. Four runs have four offsets: too few to show a mean, or an influence of speed or
temperature, in this scatter.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of
from sim.tests.workbench.small_sets import ALPHA, ARCSEC, COUNTS_PER_REV, measurement_set

from arctrue.measurement import Capture, MeasurementSet, Table
from arctrue.workbench.diagnose.of_the_runs import offsets_follow
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.observations.build import observations_of

TERMS = [Term(built_in()["graduation_harmonics"](), {})]

OF_THE_RUNS = {"timing_skew", "head_angle_error", "thermal_head_drift"}


def _scattered(offsets: list[int]) -> MeasurementSet:
    """Return the plain set with these counts added to head 2, one value per run."""
    made = measurement_set(turns=2, cycles=4)
    capture = made.capture
    assert capture is not None
    shift = np.array(offsets, dtype=np.int64)[capture.run]
    return replace(made, capture=replace(capture, head2_counts=capture.head2_counts + shift))


@pytest.mark.parametrize(
    "offsets",
    [
        pytest.param([-20, -15, -14, -5], marks=pytest.mark.large),
        pytest.param([20, -14, 12, 18], marks=pytest.mark.large),
        [-5, -20, 19, -13],
    ],
)
def test_offsets_of_a_poor_index_have_no_name(offsets: list[int]) -> None:
    found = diagnosis_of(_scattered(offsets))
    assert found.named is None
    assert not OF_THE_RUNS & set(found.effect_class)


@pytest.mark.large
def test_a_skew_within_a_good_index_keeps_its_name() -> None:
    """The diagnosis names a skew of 3 µs if the index is good: the skew gives 0.32, −0.32 and 0.97″
    at 30, −30 and 90 °/s, which are four to twelve counts."""
    found = diagnosis_of(measurement_set(head2_only=lambda time, speed: 0 * time + 0.62 * speed))
    assert found.named is not None
    assert found.named.name == "timing_skew"


def _runs_at_temperatures(slope_arcsec_k: float, seed: int) -> MeasurementSet:
    """Return ten runs at ten temperatures; head 2 moves with the temperature of its bracket, and
    the thermometer has 0.2 K of noise in each row."""
    random = np.random.default_rng(seed)
    size, runs = 500, 10
    warm = random.uniform(-1.5, 1.5, runs)
    columns: dict[str, list[np.ndarray]] = {name: [] for name in ("time", "h1", "h2", "warm")}
    for run in range(runs):
        angle = random.uniform(0.0, 6.0) + np.arange(size) * 2.0 * np.pi / size
        for name, offset, move in (("h1", 0.0, 0.0), ("h2", ALPHA, slope_arcsec_k * warm[run])):
            disc = angle + offset
            value = (
                disc + (90.0 * np.cos(disc + 0.4) + move + random.normal(0.0, 0.1, size)) * ARCSEC
            )
            counts = np.round(value / (2.0 * np.pi) * COUNTS_PER_REV).astype(np.int64)
            columns[name].append(counts + random.integers(-1, 2))
        columns["time"].append(600.0 * run + np.arange(size) * 0.02)
        columns["warm"].append(20.0 + warm[run] + random.normal(0.0, 0.2, size))
    joined = {name: np.concatenate(values) for name, values in columns.items()}
    capture = Capture(
        np.repeat(np.arange(runs), size),
        joined["time"],
        joined["h1"],
        joined["h2"],
        temperature_c=joined["warm"],
    )
    table = Table(counts_per_rev=COUNTS_PER_REV, head_separation_deg=33.0)
    return MeasurementSet(table, capture, None, title="ten runs")


@pytest.mark.parametrize("seed", [1, 2])
def test_runs_that_follow_the_temperature_are_no_adequate_model(seed: int) -> None:
    """The model is never adequate if the offsets of ten runs lie on a line over the temperature,
    five times the scatter of the index, although the noise of the thermometer hides the slope
    within the runs."""
    found = diagnosis_of(_runs_at_temperatures(0.5, seed))
    assert found.verdict in ("named", "ambiguous", "unknown")
    if found.verdict == "unknown":
        assert any("temperature" in text for text in sentences(found))
        assert found.measurement is not None
        assert found.measurement.kind == "warm"
    else:
        assert "thermal_head_drift" in found.effect_class


@pytest.mark.parametrize(
    "seed", [pytest.param(1, marks=pytest.mark.large), 2, pytest.param(3, marks=pytest.mark.large)]
)
def test_runs_that_follow_nothing_are_adequate(seed: int) -> None:
    assert diagnosis_of(_runs_at_temperatures(0.0, seed)).verdict in ("adequate", "cannot_tell")


def test_runs_that_follow_the_signed_speed_are_found() -> None:
    """The signed speed is one of the conditions, although the size and the square of the speed do
    not follow the offsets."""
    speeds = np.array([1.0, -1.0, 0.5, -0.5, 2.0, -2.0])
    made = _runs_at_speeds(speeds, 1.0 * speeds)
    found = offsets_follow(Residuals(fit(TERMS, observations_of(made))))
    assert found is not None
    assert found.part == "speed"
    same = _runs_at_speeds(speeds, np.array([0.4, -0.9, 0.7, 0.8, -0.6, -0.4]))
    assert offsets_follow(Residuals(fit(TERMS, observations_of(same)))) is None


def test_runs_that_follow_the_square_of_a_condition_are_found() -> None:
    """Eight offsets on a parabola over the signed speed, without a linear part, follow the speed,
    and eight random offsets do not: three coefficients leave five degrees of freedom."""
    speeds = np.array([1.0, -1.0, 0.5, -0.5, 2.0, -2.0, 1.5, -1.5])
    made = _runs_at_speeds(speeds, 0.8 * (speeds - 0.4) ** 2)
    found = offsets_follow(Residuals(fit(TERMS, observations_of(made))))
    assert found is not None
    assert found.part in ("speed", "abs_speed", "speed^2")
    same = _runs_at_speeds(speeds, np.random.default_rng(6).normal(0.0, 0.8, 8))
    assert offsets_follow(Residuals(fit(TERMS, observations_of(same)))) is None


def test_a_poor_index_is_stated_and_lowers_none() -> None:
    """The offsets of six runs at one speed scatter by 5″ and follow no recorded condition; the
    report states the scatter, and the probability of ``none`` is at most its prior."""
    offsets = np.array([-3.0, 0.5, 4.0, 8.0, 12.0, 2.0])
    found = diagnosis_of(_runs_at_speeds(np.full(6, 1.0), offsets))
    assert any("The offsets of the runs scatter by" in text for text in sentences(found))
    assert found.probability["none"] <= 0.5
    assert sum(found.probability.values()) == pytest.approx(1.0)


@pytest.mark.large
def test_a_good_index_is_not_mentioned() -> None:
    found = diagnosis_of(measurement_set())
    assert found.index_scatter is None


def _runs_at_speeds(speeds: np.ndarray, offsets_arcsec: np.ndarray) -> MeasurementSet:
    """Return one turn at each speed in rad/s; head 2 has an offset in each run."""
    random = np.random.default_rng(3)
    size = 400
    columns: list[list[np.ndarray]] = [[], [], []]
    for run, (speed, offset) in enumerate(zip(speeds, offsets_arcsec, strict=True)):
        since = np.arange(size) * 2.0 * np.pi / size / abs(speed)
        columns[0].append(100.0 * run + since)
        for column, place, shift in ((1, 0.0, 0.0), (2, ALPHA, offset)):
            disc = speed * since + place
            error = 90.0 * np.cos(disc + 0.4) + shift + random.normal(0.0, 0.1, size)
            value = (disc + error * ARCSEC) / (2.0 * np.pi) * COUNTS_PER_REV
            columns[column].append(np.round(value).astype(np.int64))
    capture = Capture(
        np.repeat(np.arange(speeds.size), size), *(np.concatenate(values) for values in columns)
    )
    table = Table(counts_per_rev=COUNTS_PER_REV, head_separation_deg=33.0)
    return MeasurementSet(table, capture, None, title="six speeds")
