"""Tests that an effect of the stated detectable size is found in 95 % of the sets, whether noise,
few runs, slow noise or held-out rows limit this size."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import stats
from scipy.special import chndtr, gammaincinv, ncfdtr
from sim.tests.workbench.small_sets import RUNS, TURNS, measurement_set

from arctrue.measurement import MeasurementSet
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.detectable import (
    _not_passed,
    _powerful,
    held_out_gain,
    needed_gain,
    smallest_detectable,
)
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.likelihood_ratio import Null, evidence
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import SIGNIFICANCE, corrected_p_value
from arctrue.workbench.observations.build import observations_of

Float = NDArray[np.float64]
EFFECTS = built_in()
TESTS = 19
"""Number of effects that a diagnosis tests: the effects of the catalogue, except that of the model
and the geometry of a mount, which needs a second axis."""
SETS = 12
LEAST = 9
"""Smallest accepted number of sets, of 12, in which the effect is found. At a rate of 95 %, fewer
sets occur in 1 of 450 such tests (binomial)."""
INDEX_ARCSEC = 0.08
"""Standard deviation of a run's offset in arcseconds, about one count of 0.077″."""


@pytest.mark.parametrize(("rank", "freedom"), [(1, 10.0), (1, 4.0), (3, 20.0), (23, 60.0)])
def test_needed_gain_has_its_power_in_drawn_noise(rank: int, freedom: float) -> None:
    """The needed gain has the stated power in simulated noise. The set that states the size and the
    set that contains the effect have independent noise estimates, so that each draws a χ² of its
    own."""
    random = np.random.default_rng(5)
    gain = needed_gain(rank, TESTS, freedom)
    size, draws = np.sqrt(gain), 40_000
    stating, showing = (random.chisquare(freedom, draws) / freedom for _ in range(2))
    columns = random.normal(size=(draws, rank))
    columns[:, 0] += size * np.sqrt(stating)
    ratio = np.sum(columns**2, axis=1) / rank / showing
    found = float(np.mean(ratio > stats.f.ppf(1.0 - SIGNIFICANCE / TESTS, rank, freedom)))
    # The tolerance is three standard errors of 40,000 draws at 95 %, plus the error from 32
    # quantiles of the noise.
    assert found == pytest.approx(0.95, abs=0.0033 + 0.003)


def test_noise_that_two_degrees_of_freedom_state_has_a_bound_too() -> None:
    """A detectable size exists also for noise with two degrees of freedom: the log of a servo
    needed an F above 10⁷, at which the series of the noncentral F distribution gives NaN."""
    rank, freedom, threshold, draws = 4, 2.0, 3.8e7, 200_000
    random = np.random.default_rng(7)
    stating, showing = (random.chisquare(freedom, draws) / freedom for _ in range(2))
    columns = random.normal(size=(draws, rank))
    columns[:, 0] += np.sqrt(_powerful(rank, freedom, threshold) * stating)
    found = float(np.mean(np.sum(columns**2, axis=1) / rank / showing > threshold))
    # The tolerance is three standard errors of the draws, plus the error from 32 quantiles of noise
    # with two degrees of freedom.
    assert found == pytest.approx(0.95, abs=0.0015 + 0.012)


@pytest.mark.parametrize("rank", [1, 2, 8])
def test_rows_left_out_show_it_with_the_stated_power(rank: int) -> None:
    """Left-out rows show the effect with the stated power. The test computes four folds with least
    squares in numpy; the effect counts as found if the log predictive density rises by twice the
    standard error of the rise."""
    random = np.random.default_rng(6)
    rows, draws = 400, 1500
    columns = np.linalg.qr(random.normal(size=(rows, rank)))[0]
    folds = np.arange(rows) % 4
    parts = [(columns[folds == fold], np.linalg.pinv(columns[folds != fold])) for fold in range(4)]
    size = np.sqrt(held_out_gain(rank, 1.0))
    shown = 0
    for _ in range(draws):
        values = size * columns[:, 0] + random.normal(size=rows)
        change = np.zeros(rows)
        for fold, (out, inverse) in enumerate(parts):
            change[folds == fold] = out @ (inverse @ values[folds != fold])
        gain = 0.5 * float(values @ values - (values - change) @ (values - change))
        shown += gain > 2.0 * np.linalg.norm(change)
    # The bound is three standard errors of 1,500 draws at 95 %, plus 2 % for the scatter of the
    # folds, which the formula ignores.
    assert shown / draws == pytest.approx(0.95, abs=0.017 + 0.02)


def _of_runs(seed: int, added: Callable[[int, Float], Float]) -> MeasurementSet:
    """Return a set with four runs, whose offsets scatter. ``added`` is called with the number of
    the run and the place within the run (0 … 1); it returns the error that is added to head 2."""
    random = np.random.default_rng([seed, 1])
    offsets = random.normal(0.0, INDEX_ARCSEC, len(RUNS))
    starts = np.array([start for *_, start in RUNS]) / TURNS

    def head2(time: Float, _: float) -> Float:
        run = int(np.searchsorted(starts, time[0], side="right")) - 1
        within = (time - time[0]) / (time[-1] - time[0])
        return offsets[run] + added(run, within)

    return measurement_set(seed=seed, reference=False, turns=1, head2_only=head2)


def _wandering(seed: int, added: Callable[[Float, Float], Float]) -> MeasurementSet:
    """Return a set with a reference whose noise is half white and half slow: 0.15″ each; the slow
    part has a correlation time of 100 s."""
    random = np.random.default_rng([seed, 2])
    made = measurement_set(seed=seed, runs=1, turns=1, cycles=6)
    assert made.reference is not None
    time, direction = made.reference.time_s, made.reference.direction
    assert time is not None
    assert direction is not None
    slow = np.zeros(time.size)
    keep = np.exp(-4.0 / 100.0)
    for row in range(1, time.size):
        slow[row] = keep * slow[row - 1] + random.normal(0.0, 0.15 * np.sqrt(1.0 - keep**2))
    values = made.reference.error_arcsec + slow + added(time, direction.astype(np.float64))
    return replace(made, reference=replace(made.reference, error_arcsec=values))


def _made(effect: str, seed: int, size: float) -> MeasurementSet:
    """Return a set that contains an effect; by its definition the effect has the RMS ``size`` in
    the channel that shows it."""
    if effect == "reference_drift":
        return _wandering(seed, lambda time, _: size * np.sqrt(12.0) * time / np.ptp(time))
    if effect == "hysteresis":
        return _wandering(seed, lambda _, direction: size * direction)

    def form(run: int, within: Float) -> Float:
        speed, cold, warm, _ = RUNS[run]
        return {
            "head_angle_error": np.ones_like(within),
            "timing_skew": np.full_like(within, speed),
            "thermal_head_drift": cold - 20.0 + (warm - cold) * within,
        }[effect]

    places = np.linspace(0.0, 1.0, 100)
    square = np.mean([form(run, places) ** 2 for run in range(len(RUNS))])
    return _of_runs(seed, lambda run, within: size * form(run, within) / np.sqrt(square))


def _residuals(made: MeasurementSet) -> Residuals:
    return Residuals(fit([Term(EFFECTS["graduation_harmonics"](), {})], observations_of(made)))


@pytest.mark.large
@pytest.mark.parametrize(
    ("effect", "channel"),
    [
        ("head_angle_error", "capture"),
        ("timing_skew", "capture"),
        ("thermal_head_drift", "capture"),
        ("reference_drift", "reference"),
        ("hysteresis", "reference"),
    ],
)
def test_an_effect_at_the_bound_is_found(effect: str, channel: str) -> None:
    """The diagnosis finds an effect at the bound, where few runs or slow noise determine the
    detectable size: one set states this size, and the next set contains an effect of this size."""
    found = 0
    for seed in range(SETS):
        of = EFFECTS[effect]()
        stated = smallest_detectable(_residuals(_made(effect, seed, 0.0)), of, {}, TESTS)
        assert stated is not None
        made = _made(effect, seed + SETS, stated.rms_arcsec[channel])
        residuals = _residuals(made)
        reported = evidence(Null(residuals), of, {})
        p_value = corrected_p_value(
            reported.gain, reported.score.rank, 1.0, TESTS, reported.freedom
        )
        found += p_value < SIGNIFICANCE
    assert found >= LEAST


def test_no_noncentrality_is_without_a_power() -> None:
    """Scipy's noncentral F is NaN for one of a hundred of these arguments, mostly where it is
    nearly 0.

    The expected value is the mean of noncentral χ² probabilities over the quantiles of the
    denominator. Patnaik's F differs from it by at most 0.01.
    """
    random = np.random.default_rng(0)
    size = 20_000
    rank = random.integers(1, 240, size)
    freedom, gain = 10.0 ** random.uniform(1, 4, size), 10.0 ** random.uniform(2.7, 4.3, size)
    threshold = 10.0 ** random.uniform(0.0, 1.8, size)
    lost = np.flatnonzero(np.isnan(ncfdtr(rank, freedom, gain, threshold)))
    assert lost.size > 20
    levels = (np.arange(500) + 0.5) / 500.0
    for at in lost[:40]:
        found = _not_passed(int(rank[at]), freedom[at], gain[at : at + 1], threshold[at])[0]
        share = gammaincinv(0.5 * freedom[at], levels) / (0.5 * freedom[at])
        expected = np.mean(chndtr(threshold[at] * rank[at] * share, rank[at], gain[at]))
        assert found == pytest.approx(expected, abs=0.01)
