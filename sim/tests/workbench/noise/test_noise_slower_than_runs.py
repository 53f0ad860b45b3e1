"""Tests that noise slower than the runs of a capture is no wrong angle between the heads.

The simulation is plain numpy: a disc's error of three orders, an index of ±1 count, and noise of
R₂ − R₁ that continues over the pauses between four runs.
"""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of
from sim.tests.workbench.small_sets import ALPHA, ARCSEC, COUNTS_PER_REV

from arctrue.measurement import Capture, MeasurementSet, Table
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.likelihood_ratio import Null, evidence
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.slow_offsets import p_in_slower_noise
from arctrue.workbench.noise.slower_noise import SlowerNoise, correlation_of_means
from arctrue.workbench.observations.build import observations_of

STARTS_S = np.array([0.0, 60.0, 120.0, 1800.0])
LENGTHS_S = np.array([36.0, 36.0, 12.0, 36.0])
SENSES = (1, -1, 1, 1)
TURNS = 3
LONGEST_S = 300.0
"""Longest time constant of the noise: noise slower than this does not exist."""


def _relaxation(random: np.random.Generator, time_s: np.ndarray, constant_s: float) -> np.ndarray:
    """Return Ornstein–Uhlenbeck noise of variance 1, exact at unevenly spaced times."""
    steps = np.diff(time_s, prepend=time_s[0] - 1e9)
    kept = np.exp(-steps / constant_s)
    kicks = np.sqrt(1.0 - kept**2) * random.normal(size=time_s.size)
    found, last = np.empty(time_s.size), 0.0
    for row, (factor, kick) in enumerate(zip(kept.tolist(), kicks.tolist(), strict=True)):
        last = factor * last + kick
        found[row] = last
    return found


def _power_law(seed: int, time_s: np.ndarray, exponent: float) -> np.ndarray:
    """Return noise of variance 1 with a density ∝ 1/f^exponent: relaxations with time constants in
    equal ratios and variances ∝ τ^(exponent − 1)."""
    random = np.random.default_rng(1000 + seed)
    constants = np.geomspace(0.03, LONGEST_S, 9)
    shares = constants ** (exponent - 1.0)
    shares /= shares.sum()
    return sum(
        np.sqrt(share) * _relaxation(random, time_s, constant)
        for share, constant in zip(shares.tolist(), constants.tolist(), strict=True)
    )


def _set(
    seed: int,
    *,
    slow_arcsec: float = 0.0,
    exponent: float = 1.0,
    head_angle_arcsec: float = 0.0,
    rows: int = 300,
) -> MeasurementSet:
    random = np.random.default_rng(seed)
    run = np.repeat(np.arange(4), rows)
    within = np.tile(np.arange(rows) / rows, 4)
    time_s = STARTS_S[run] + LENGTHS_S[run] * within
    angle = random.uniform(0.0, 6.0, 4)[run] + np.array(SENSES)[run] * within * TURNS * 2.0 * np.pi
    slow = slow_arcsec * _power_law(seed, time_s, exponent)
    counts = []
    for place, own in ((0.0, 0.0), (ALPHA, slow + head_angle_arcsec)):
        disc = angle + place
        error = 90.0 * np.cos(disc + 0.4) + 0.8 * np.cos(2.0 * disc) + 0.5 * np.cos(3.0 * disc)
        error += random.normal(0.0, 0.05, run.size) + own
        read = np.round((disc + error * ARCSEC) / (2.0 * np.pi) * COUNTS_PER_REV)
        counts.append(read.astype(np.int64) + random.integers(-1, 2, 4)[run])
    table = Table(counts_per_rev=COUNTS_PER_REV, head_separation_deg=33.0)
    return MeasurementSet(table, Capture(run, time_s, *counts), None, title="slow noise")


def _p_values(made: MeasurementSet) -> tuple[float, float]:
    """Return the gain of head_angle_error and its p in noise slower than the runs."""
    effects = built_in()
    terms = [Term(effects["graduation_harmonics"](orders=[1, 2, 3]), {})]
    effect = effects["head_angle_error"]()
    found = evidence(Null(Residuals(fit(terms, observations_of(made)))), effect, {})
    return found.gain, p_in_slower_noise(found.base, effect, {})


@pytest.mark.parametrize("seed", [26, 58, 66, 89, 147, 159])
def test_slow_noise_over_the_pauses_is_no_wrong_angle(seed: int) -> None:
    """With noise of 0.3″ and a density ∝ 1/f^1.7, successive runs have nearly the same offset. If
    each run's noise began anew, head_angle_error would be the answer for each of these seeds."""
    found = diagnosis_of(_set(seed, slow_arcsec=0.3, exponent=1.7))
    assert found.named is None
    assert "head_angle_error" not in found.effect_class


@pytest.mark.parametrize("seed", [58, 89])
def test_a_wrong_angle_ten_times_the_slow_noise_is_named(seed: int) -> None:
    found = diagnosis_of(_set(seed, slow_arcsec=0.3, exponent=1.7, head_angle_arcsec=3.0))
    assert found.named is not None
    assert found.named.name == "head_angle_error"


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("head_angle_arcsec", [0.0, 0.5])
def test_white_noise_changes_no_p(seed: int, head_angle_arcsec: float) -> None:
    """In white noise the test of slower noise adds nothing: its p is exactly 0."""
    gain, p_value = _p_values(_set(seed, head_angle_arcsec=head_angle_arcsec))
    assert p_value == 0.0
    assert (gain > 15.0) == (head_angle_arcsec > 0.0)


@pytest.mark.large
def test_p_of_the_offsets_is_no_smaller_than_its_rate() -> None:
    """Over 200 sets of slow noise without an effect, p falls below 0.01 as often as p claims: a
    binomial variable of mean 2 exceeds 7 with a probability of 0.001."""
    random = np.random.default_rng(3)
    below = 0
    for seed in range(500, 700):
        size, exponent = np.exp(random.uniform(np.log(0.03), np.log(0.3))), random.uniform(0.5, 1.8)
        gain, p_value = _p_values(_set(seed, slow_arcsec=float(size), exponent=float(exponent)))
        below += 0.0 < p_value < 0.01 and gain > 6.6
    assert below <= 7


def test_the_covariance_of_means_is_the_mean_of_the_covariances() -> None:
    """The closed form equals the mean over all pairs of 2,000 evenly spaced instants per run."""
    first, last = STARTS_S, STARTS_S + LENGTHS_S
    found = correlation_of_means(first, last, 50.0)
    instants = first[:, None] + LENGTHS_S[:, None] * (np.arange(2000) + 0.5) / 2000
    for one in range(4):
        for other in range(4):
            apart = np.abs(instants[one][:, None] - instants[other])
            assert found[one, other] == pytest.approx(np.exp(-apart / 50.0).mean(), rel=1e-5)


def test_runs_before_the_clock_goes_back_are_not_correlated_with_later_runs() -> None:
    first = np.array([0.0, 60.0, 0.0, 60.0])
    found = correlation_of_means(first, first + 36.0, 50.0)
    assert np.all(found[:2, 2:] == 0.0)
    np.testing.assert_allclose(found[:2, :2], found[2:, 2:])


def test_flicker_noise_continues_with_equal_variance_in_each_octave() -> None:
    """Noise with the density h/f has the variance 2·h·ln r between the time constants τ and r·τ
    (integral of the two-sided density over the same ratio of frequencies)."""
    slow = SlowerNoise(36.0, 1836.0, 0.5, 0.4)
    expected = 2.0 * (slow.density / slow.length_s) * np.log(1836.0 / 36.0)
    assert slow.variances(1.0).sum() == pytest.approx(expected, rel=0.1)


def test_a_random_walk_has_the_density_of_its_steps() -> None:
    """With the exponent 2 most of the density at the run's length belongs to slower parts, and
    the variance of each part grows as its time constant."""
    slow = SlowerNoise(36.0, 1836.0, 0.5, 0.4)
    variances = slow.variances(2.0)
    turning = 2.0 * np.pi / slow.length_s * slow.constants_s
    density = float(np.sum(2.0 * variances * slow.constants_s / (1.0 + turning**2)))
    assert 0.5 * slow.density < density < slow.density
    np.testing.assert_allclose(variances / slow.constants_s, variances[0] / slow.constants_s[0])
