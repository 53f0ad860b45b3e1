"""Tests of captures whose heads have unequal noise: the estimated noise of each head, contrasts
without correlation, and false alarms of the score test."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import binom, chi2

from arctrue.measurement import MeasurementSet
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.base import FitContext
from arctrue.workbench.effects.capture_block import capture_block
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.every_row import channel_figures
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.fixed import with_fixed_coefficients
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.steps import step_scan
from arctrue.workbench.numeric.least_squares import WhitenedRows, divided_by_constants
from arctrue.workbench.observations import part
from arctrue.workbench.observations.build import observations_of
from arctrue.workbench.observations.contrasts import contrast_weights, offset_weights
from arctrue.workbench.observations.head_noise import HeadNoise, samples_for_noise
from arctrue.workbench.observations.observations import Observations
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.heads.four_heads import COUNTS, LINES, NOISE_ARCSEC, PLACES_DEG, FourHeads

Float = NDArray[np.float64]
NOISY_ARCSEC = 0.5
"""Noise that a noisy head has beyond the 0.1″ of every head."""
OF_THREE = (0.0, 118.0, 237.0)
LEVEL, DRAWS, ORDERS = 0.01, 200, (2, 3, 5, 7, 11)
"""Nominal p, number of draws of the noise for each set, and orders of the disc that are tested."""


@dataclass
class Noisy(FourHeads):
    """A table whose heads have noise of their own beyond that of the others."""

    more_arcsec: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)

    def _readings(
        self, number: int, now: Float, speed: float, warmth: Float, random: np.random.Generator
    ) -> list[NDArray[np.int64]]:
        found = super()._readings(number, now, speed, warmth, random)
        return [
            counts + np.rint(random.normal(0.0, 1.0, counts.size) * more * COUNTS / 1_296_000.0)
            .astype(np.int64)
            for counts, more in zip(found, self.more_arcsec, strict=False)
        ]  # fmt: skip


def _noisy(
    head: int, places_deg: tuple[float, ...] = PLACES_DEG, more: float = NOISY_ARCSEC
) -> Noisy:
    sizes = tuple(more if number == head else 0.0 for number in range(1, len(places_deg) + 1))
    return Noisy(places_deg=places_deg, more_arcsec=sizes)


def _observations(measurement: MeasurementSet) -> Observations:
    return observations_of(measurement, mask_outliers=False)


@pytest.mark.parametrize("places_deg", [PLACES_DEG, OF_THREE], ids=["four", "three"])
@pytest.mark.parametrize("head", [1, 2, 3])
def test_the_noise_of_each_head_is_found(head: int, places_deg: tuple[float, ...]) -> None:
    for seed in (1, 2, 3):
        rows = _observations(_noisy(head, places_deg).measured(seed)).capture
        assert rows is not None
        assert rows.head_noise is not None
        found = np.array(rows.head_noise.sigmas_arcsec)
        expected = np.full(len(places_deg), NOISE_ARCSEC)
        expected[head - 1] = np.hypot(NOISE_ARCSEC, NOISY_ARCSEC)
        # Four runs of 800 samples and the window give 823 independent complex values. With three
        # heads, the variance of a quiet head is the covariance of Rᵢ − R₁ and Rᵢ − Rⱼ. Its standard
        # deviation is 0.5·0.1·√(1/823) = 0.0018 arcsec², so that σ scatters by 9 %. The σ of the
        # noisy head scatters by 1/√(4·823) = 2 %. The limits that exclude lines lower every σ by 2
        # %.
        limit = np.where(expected > NOISE_ARCSEC, (0.02 + 4.0 * 0.018) * expected, 0.038)
        assert np.all(np.abs(found - expected) < limit), found


@pytest.mark.parametrize("places_deg", [PLACES_DEG, OF_THREE], ids=["four", "three"])
def test_heads_of_equal_noise_keep_their_weights(places_deg: tuple[float, ...]) -> None:
    """Slips, drifts, vibrations, interpolation errors and wrong rows of one head are no noise of
    this head."""
    count = COUNTS / 1_296_000.0
    for seed in (1, 2, 3):
        still = FourHeads(places_deg=places_deg).measured(seed)
        assert still.capture is not None
        time, counts = still.capture.time_s, np.asarray(still.capture.head2_counts)
        phase = 2.0 * np.pi * LINES / COUNTS * (counts % (COUNTS // LINES))
        wrong = counts.copy()
        wrong[np.random.default_rng(seed).choice(counts.size, 6, replace=False)] += 200
        others = [
            counts + np.rint(5.0 * np.cos(2.0 * np.pi * 7.3 * time) * count).astype(np.int64),
            counts + np.rint(0.002 * time * count).astype(np.int64),
            wrong,
            counts
            + np.rint(0.3 * sum(np.cos(k * phase + k) for k in (1, 2, 4)) * count).astype(np.int64),
        ]
        sets = [still, FourHeads(places_deg=places_deg, slip=(1, 2, 40)).measured(seed)]
        sets += [
            replace(still, capture=replace(still.capture, head2_counts=item)) for item in others
        ]
        for number, measurement in enumerate(sets):
            rows = _observations(measurement).capture
            assert rows is not None
            assert rows.head_noise is None, number
            assert rows.offset_weights is None


def test_two_heads_have_no_weights() -> None:
    rows = _observations(_noisy(1, PLACES_DEG[:2]).measured(1)).capture
    assert rows is not None
    assert rows.head_noise is None
    assert np.array_equal(rows.weights, [[1.0]])


def test_contrasts_of_unequal_heads_are_independent() -> None:
    """With the weights of the true variances, the contrasts have a diagonal covariance, and their
    offsets have the covariance of equal indexes. For equal variances these weights are those of the
    Helmert contrasts."""
    variances = np.array([0.25, 0.01, 0.04, 0.01])
    covariance = np.diag(variances[1:]) + variances[0]
    weights = contrast_weights(4, covariance)
    found = weights @ covariance @ weights.T
    assert np.abs(found - np.diag(np.diag(found))).max() < 1e-14
    of_index = np.eye(3) + 1.0
    # Errors of equal size in all heads have the variance 2 in each contrast, as in R₂ − R₁.
    assert np.abs(np.diag(weights @ of_index @ weights.T) - 2.0).max() < 1e-14
    mixed = offset_weights(4, covariance)
    assert np.abs(2.0 * mixed @ mixed.T - weights @ of_index @ weights.T).max() < 1e-14
    equal = np.full(4, 0.3)
    again = contrast_weights(4, np.diag(equal[1:]) + equal[0])
    assert np.abs(again - contrast_weights(4)).max() < 1e-14


def _alarms(observations: Observations, sigmas: Float, random: np.random.Generator) -> int:
    """Return how often the test of one of the ORDERS of the disc has p below LEVEL, in DRAWS of
    noise alone. The test assumes independent channels, as the fit does."""
    rows = observations.capture
    assert rows is not None
    assert rows.channel is not None
    columns = capture_block(built_in()["graduation_harmonics"](), rows, {}, FitContext())
    assert columns is not None
    noise = random.normal(size=(DRAWS, sigmas.size, rows.run.size // rows.channels))
    noise *= sigmas[:, np.newaxis]
    channels = rows.weights @ (noise[:, 1:] - noise[:, :1])
    scatter = np.std(channels, axis=(0, 2))
    values = np.empty((DRAWS, rows.run.size))
    for channel in range(rows.channels):
        values[:, rows.channel == channel] = channels[:, channel] / scatter[channel]
    found = 0
    for order in ORDERS:
        own = columns[:, 2 * order - 2 : 2 * order] / scatter[rows.channel][:, np.newaxis]
        gains = np.sum((values @ np.linalg.qr(own)[0]) ** 2, axis=1)
        found += int(np.sum(gains > chi2.isf(LEVEL, 2)))
    return found


@pytest.mark.parametrize(
    ("head", "places_deg"),
    [(1, PLACES_DEG), (2, PLACES_DEG), (1, OF_THREE), (2, OF_THREE)],
    ids=["first_of_four", "second_of_four", "first_of_three", "second_of_three"],
)
def test_noise_of_one_head_makes_no_false_alarms(head: int, places_deg: tuple[float, ...]) -> None:
    """In noise alone, an order of the disc has p below LEVEL as often as stated. With the weights
    of equal heads this is more frequent, with four heads more than twice as frequent."""
    sigmas = np.full(len(places_deg), NOISE_ARCSEC)
    sigmas[head - 1] = np.hypot(NOISE_ARCSEC, NOISY_ARCSEC)
    alarms = of_equal = 0
    for seed in (1, 2, 3):
        observations = _observations(replace(_noisy(head, places_deg), samples=300).measured(seed))
        assert observations.capture is not None
        assert observations.capture.head_noise is not None
        equal = replace(observations, capture=replace(observations.capture, head_noise=None))
        alarms += _alarms(observations, sigmas, np.random.default_rng(100 + seed))
        of_equal += _alarms(equal, sigmas, np.random.default_rng(100 + seed))
    tests = 3 * DRAWS * len(ORDERS)
    # The bound is the 0.1 % point of the binomial distribution.
    assert alarms <= binom.isf(1e-3, tests, LEVEL), (alarms, of_equal)
    # Of three heads, the order that suffers most is not among these.
    assert of_equal > (2 if len(places_deg) == 4 else 1) * alarms


def test_the_order_of_the_heads_does_not_change_p() -> None:
    """With known noise of each head, heads in another order give the same gain of the disc."""
    sigmas = np.array([0.5, 0.1, 0.2, 0.1])
    places = np.radians(PLACES_DEG)
    angle = np.linspace(0.0, 4.0 * np.pi, 300)
    random = np.random.default_rng(4)
    readings = random.normal(size=(4, angle.size)) * sigmas[:, np.newaxis]
    gains = []
    for order in permutations(range(4)):
        of = list(order)
        noise = sigmas[of] ** 2
        covariance = np.diag(noise[1:]) + noise[0]
        weights = contrast_weights(4, covariance)
        scatter = np.sqrt(np.diag(weights @ covariance @ weights.T))[:, np.newaxis]
        seen = [
            np.stack([f(7.0 * (angle + place)) for f in (np.cos, np.sin)]) for place in places[of]
        ]
        apart = np.array(seen[1:]) - seen[0]
        columns = np.einsum("ch,hks->kcs", weights / scatter, apart).reshape(2, -1)
        measured = (weights / scatter @ (readings[of][1:] - readings[of][0])).reshape(-1)
        left = np.linalg.lstsq(columns.T, measured, rcond=None)[1]
        gains.append(float(measured @ measured - left[0]))
    assert np.ptp(gains) < 1e-9 * max(gains)


def test_the_fit_does_not_depend_on_the_order_of_the_heads() -> None:
    """Heads 2 to 4 in another order leave the gain of an effect within the error of the estimated
    noise."""
    measured = _noisy(2).measured(3)
    capture = measured.capture
    assert capture is not None
    heads = np.stack([np.asarray(counts) for counts in capture.heads])
    gains = []
    for order in ((0, 1, 2, 3), (0, 3, 2, 1), (0, 2, 3, 1)):
        of = list(order)
        counts = {f"head{place + 1}_counts": heads[number] for place, number in enumerate(of)}
        other = replace(
            measured,
            table=replace(
                measured.table,
                head_separation_deg=None,
                head_places_deg=tuple(PLACES_DEG[number] for number in of),
            ),
            capture=replace(capture, **counts),
        )
        effects = built_in()
        residuals = Residuals(
            fit([Term(effects["graduation_harmonics"](), {})], _observations(other))
        )
        gains.append(residuals.score(effects["radial_error_motion"](), {}).gain)
    # The scales of the runs are estimated from 800 rows each, 2.5 %; three channels in four runs
    # change a gain by less than 5 %.
    assert np.ptp(gains) < 0.05 * max(gains)


def test_offsets_of_the_runs_are_those_of_equal_indexes() -> None:
    """The fitted offsets are the Helmert contrasts of the heads' zeros, also with unequal noise."""
    measured = _noisy(1).measured(5)
    observations = _observations(measured)
    solution = fit([Term(built_in()["graduation_harmonics"](), {})], observations)
    rows, other = observations.capture, replace(_noisy(1), more_arcsec=(0.0,) * 4).measured(5)
    equal = _observations(other).capture
    assert rows is not None
    assert rows.head_noise is not None
    assert equal is not None
    assert equal.head_noise is None
    # The other set has the same zeros without the noise of head 1, in Helmert contrasts.
    plain = fit([Term(built_in()["graduation_harmonics"](), {})], _observations(other))
    # The mean of 800 rows of 0.5″ has σ = 0.018″, times √2 in a contrast.
    apart = solution.run_offsets_arcsec - plain.run_offsets_arcsec
    assert np.abs(apart).max() < 4.0 * 0.026
    left = solution.capture_residual_arcsec()
    assert left is not None
    assert np.abs(np.bincount(rows.run, left) / np.bincount(rows.run)).max() < 4.0 * 0.026


def test_mixed_offsets_sum_like_columns() -> None:
    random = np.random.default_rng(3)
    rows, shared, runs = 500, 4, 6
    columns, measured = random.normal(size=(rows, shared)), random.normal(size=rows)
    run = np.sort(random.integers(0, runs, rows))
    ones = random.uniform(0.5, 2.0, rows)
    mixed = np.tril(random.normal(size=(3, 3)))
    every = ones[:, np.newaxis] * (np.eye(runs)[run] @ np.kron(np.eye(2), mixed))
    design = np.hstack([columns, every])
    found = WhitenedRows(columns, ones, run, runs, mixed)
    coefficients = random.normal(size=shared + runs)
    np.testing.assert_allclose(found.every_column, design, atol=1e-12)
    np.testing.assert_allclose(found.gram, design.T @ design, atol=1e-9)
    np.testing.assert_allclose(found.moment(measured), design.T @ measured, atol=1e-9)
    np.testing.assert_allclose(found.model(coefficients), design @ coefficients, atol=1e-9)
    cross, constants = found.gram[:shared, shared:], found.gram[shared:, shared:]
    expected = cross @ np.linalg.inv(constants)
    np.testing.assert_allclose(divided_by_constants(cross, constants, 0.0), expected, atol=1e-9)


@pytest.mark.parametrize(("head", "seed"), [(1, 5), pytest.param(1, 7, marks=pytest.mark.large)])
def test_a_noisy_head_is_stated_and_is_no_error(head: int, seed: int) -> None:
    """A head five times as noisy as the others is no discovery, and the answer states its noise. An
    earlier version answered unknown, with a wave of high order of head 1."""
    found = diagnosis_of(_noisy(head).measured(seed))
    assert found.verdict == "adequate"
    said = " ".join(sentences(found))
    assert "The heads are not equally noisy: head 1 is the noisiest" in said


def test_an_unknown_covariance_states_no_noise_of_a_head() -> None:
    assert not HeadNoise(np.eye(3), ()).sentence()


def test_stored_coefficients_have_the_offsets_of_the_fit() -> None:
    """A stored model has the same run offsets and residuals as the fit of the same coefficients."""
    observations = _observations(_noisy(1).measured(4))
    fitted = fit([Term(built_in()["graduation_harmonics"](), {})], observations)
    stored = with_fixed_coefficients(fitted.terms, observations, fitted.coefficients)
    apart = stored.run_offsets_arcsec - fitted.run_offsets_arcsec
    # The noise is estimated anew; the offsets have a standard uncertainty of 0.026″ at most.
    # Without their weights in the channels they would differ by the zeros, 0.08″.
    assert np.abs(apart).max() < 0.2 * 0.026


def test_every_row_of_a_long_capture_gives_the_fit_of_a_short_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Sums over stored rows use the same weights and offsets as rows in memory."""
    measured = _noisy(1).measured(4)
    terms = [Term(built_in()["graduation_harmonics"](), {})]
    whole = fit(terms, _observations(measured))
    monkeypatch.setattr(part, "MOST_ROWS", 4_000)
    observations = _observations(measured)
    assert observations.stored is not None
    assert observations.capture is not None
    assert observations.capture.head_noise is not None
    noise = fit(terms, observations).noise
    every = fit(terms, observations, noise=noise, every_row=True)
    sigma = np.sqrt(np.diag(whole.covariance))
    # The noise is that of 40 % of the rows, so that the weights of the channels differ by 5 %.
    assert np.abs((every.coefficients - whole.coefficients) / sigma).max() < 0.3
    figures, of_whole = channel_figures(every, "capture"), channel_figures(whole, "capture")
    assert figures is not None
    assert of_whole is not None
    assert figures.rms_arcsec == pytest.approx(of_whole.rms_arcsec, rel=1e-3)


def test_many_runs_have_samples_enough_for_the_noise() -> None:
    """With 300 runs of 400 samples, each used run has all its samples: the columns of the model, up
    to 66, would remove most of a share of 166 samples."""
    run = np.repeat(np.arange(300), 400)
    kept = samples_for_noise(run)
    assert 10_000 <= kept.size <= 50_000
    assert set(np.unique(run[kept], return_counts=True)[1]) == {400}


@pytest.mark.parametrize(("noisy", "head", "counts"), [(2, 1, 1), (3, 1, 2), (2, 4, 2)])
@pytest.mark.parametrize("seed", [1, 2])
def test_the_instant_of_a_slip_is_that_with_the_largest_gain(
    noisy: int, head: int, counts: int, seed: int
) -> None:
    """The score test of every row near the slip determines the best row. The weights of unequal
    heads mix the offsets of the channels, which the instant's own search must take into account."""
    made = _noisy(noisy).measured(seed)
    assert made.capture is not None
    changed = {
        f"head{number}_counts": np.array(values)
        for number, values in enumerate(made.capture.heads, 1)
    }
    changed[f"head{head}_counts"][800 + 60 : 1600] += counts
    observations = _observations(replace(made, capture=replace(made.capture, **changed)))
    rows = observations.capture
    assert rows is not None
    slip = built_in()["count_slip"]()
    residuals = Residuals(fit([Term(built_in()["graduation_harmonics"](), {})], observations))
    found = step_scan(slip, residuals)[0]
    run = round(found.nonlinear["run"])
    own = run // rows.channels if run >= 0 else -run - 1
    times = np.unique(rows.time_s[rows.run // rows.channels == own])
    near = [{"run": found.nonlinear["run"], "instant": float(one)} for one in times[48:90]]
    best = max(residuals.score(slip, place).gain for place in near)
    assert found.gain == pytest.approx(best, rel=1e-6)
