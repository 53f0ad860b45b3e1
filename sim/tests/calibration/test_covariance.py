"""Tests that the predicted uncertainties equal the standard deviations over many simulated
captures."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.calibration import fourier, least_squares, whole_turns

from .synthetic import ARCSEC, COUNTS, Disc, capture_of, turn_angles

ALPHA = np.radians(33.0)
ORDERS = np.arange(1, 13)
DISC = Disc({1: (100.0, 0.4), 2: (0.9, 2.0), 5: (0.5, -1.0)})
TRIALS = 500


def scatter(method, noise_of, thetas, trials: int = TRIALS):
    """Return the observed and the predicted standard deviation of each order's coefficient, each as
    the RMS of the cosine and the sine component."""
    random = np.random.default_rng(11)
    values, variances = [], []
    clean = [DISC.heads(theta) for theta in thetas]
    for _ in range(trials):
        runs = [
            heads
            + np.rint(noise_of(random, heads.shape) * ARCSEC * COUNTS / (2 * np.pi)).astype(int)
            for heads in clean
        ]
        found, _ = method(whole_turns(capture_of(runs), COUNTS, None, 12), COUNTS, ALPHA, ORDERS)
        values.append(found.values)
        variances.append(np.diag(found.covariance))
    observed = np.var(values, axis=0, ddof=1).reshape(2, -1).mean(axis=0)
    predicted = np.mean(variances, axis=0).reshape(2, -1).mean(axis=0)
    return np.sqrt(observed), np.sqrt(predicted)


def white(random, shape):
    return random.normal(0.0, 0.4, shape)


@pytest.mark.parametrize("method", [fourier, pytest.param(least_squares, marks=pytest.mark.large)])
def test_white_noise_within_ten_percent(method) -> None:
    """The predicted uncertainties are right to 10 %. 500 captures determine the standard deviation
    of two components to 2.2 %; the tolerance is 4.5 times as large."""
    thetas = [turn_angles(600, 2), turn_angles(500, 1, direction=-1)]
    observed, predicted = scatter(method, white, thetas)
    assert predicted / observed == pytest.approx(1.0, abs=0.10)


def test_white_noise_of_one_turn_within_ten_percent() -> None:
    observed, predicted = scatter(least_squares, white, [turn_angles(1000, 1)])
    assert predicted / observed == pytest.approx(1.0, abs=0.10)


def test_noise_that_is_not_white() -> None:
    """The prediction is right for noise whose power falls towards high orders, so that neighbouring
    samples are correlated."""

    def red(random, shape):
        noise = random.normal(0.0, 0.15, shape)
        for index in range(1, shape[1]):
            noise[:, index] += 0.9 * noise[:, index - 1]
        return noise

    thetas = [turn_angles(600, 6)]
    observed, predicted = scatter(least_squares, red, thetas, 150)
    # The prediction averages the noise spectrum over 19 orders; over these orders the noise power
    # falls to a fifth.
    assert predicted / observed == pytest.approx(1.0, abs=0.25)
    # White noise of the same variance, 0.15²/(1 − 0.9²) per head, would give a much smaller
    # uncertainty at order 1.
    gain = 1.0 / abs(np.exp(1j * ALPHA) - 1.0)
    as_if_white = 2.0 * gain * 0.15 / np.sqrt((1.0 - 0.9**2) * 3600)
    assert predicted[0] > 2.0 * as_if_white


def test_phase_uncertainty() -> None:
    random = np.random.default_rng(2)
    phases, predicted = [], []
    for _ in range(200):
        heads = DISC.heads(turn_angles(800), 0.4, random)
        found, _ = least_squares(
            whole_turns(capture_of([heads]), COUNTS, None, 12), COUNTS, ALPHA, ORDERS
        )
        phases.append(found.phase_rad[4])
        predicted.append(found.u_phase_rad[4])
    # 200 values determine a standard deviation to 5 %.
    assert np.mean(predicted) == pytest.approx(np.std(phases, ddof=1), rel=0.2)
