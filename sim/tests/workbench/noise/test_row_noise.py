"""Tests whitening and prediction of rows against calculations with the complete covariance."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from arctrue.workbench.noise.estimate import ChannelRows, _scales, estimated_law
from arctrue.workbench.noise.likelihood import FixedTerms
from arctrue.workbench.noise.row_noise import RowNoise
from arctrue.workbench.noise.spectrum import NEGLIGIBLE, Spectrum, time_constants
from arctrue.workbench.noise.spectrum_fit import WhiteBounds

SPECTRUM = Spectrum(0.5, np.array([0.1, 2.0]), np.array([0.7, 0.3]))
SLOW = Spectrum(0.01, np.array([80.0]), np.array([16.0]))
"""Slow noise of 4″ that keeps its value for 80 s."""
BREAK = 120
"""Row at which a new stretch begins; the noise of different stretches is independent."""


@pytest.fixture
def noise() -> RowNoise:
    random = np.random.default_rng(1)
    clock = np.concatenate(
        [np.sort(random.uniform(0.0, 10.0, BREAK)), np.sort(random.uniform(0.0, 5.0, 80))]
    )
    scale = random.uniform(0.5, 2.0, clock.size)
    return RowNoise(clock, np.array([0, BREAK]), (SPECTRUM, SPECTRUM), scale)


def _written_out(noise: RowNoise) -> np.ndarray:
    apart = np.abs(noise.clock[:, None] - noise.clock)
    covariance = 0.5 * np.eye(noise.rows)
    covariance += 0.7 * np.exp(-apart / 0.1) + 0.3 * np.exp(-apart / 2.0)
    stretch = np.arange(noise.rows) >= BREAK
    covariance[stretch[:, None] != stretch] = 0.0
    return covariance * np.outer(noise.scale, noise.scale)


def test_whitened_products_are_those_of_the_inverse_covariance(noise: RowNoise) -> None:
    values = np.random.default_rng(2).normal(size=(noise.rows, 3))
    covariance = _written_out(noise)
    whitened = noise.whiten(values)
    inverse = np.linalg.solve(covariance, values)
    np.testing.assert_allclose(whitened.T @ whitened, values.T @ inverse, rtol=1e-9)
    np.testing.assert_allclose(noise.precise(whitened), inverse, rtol=1e-8, atol=1e-12)
    assert noise.log_determinant == pytest.approx(np.linalg.slogdet(covariance)[1], rel=1e-10)
    np.testing.assert_allclose(noise.coloured(whitened[:, 0]), values[:, 0], atol=1e-10)


def test_a_part_without_a_row_has_no_stretch(noise: RowNoise) -> None:
    none = noise.part(np.zeros(noise.rows, dtype=bool))
    assert none.stretches == []
    assert none.whiten(np.zeros((0, 3))).shape == (0, 3)
    assert none.log_determinant == 0.0


def test_left_out_rows_are_predicted_by_the_conditional_mean(noise: RowNoise) -> None:
    random = np.random.default_rng(3)
    values = random.normal(size=noise.rows)
    keep = random.random(noise.rows) < 0.7
    kept = noise.part(keep)
    covariance = _written_out(noise)
    expected = covariance[np.ix_(~keep, keep)] @ np.linalg.solve(
        covariance[np.ix_(keep, keep)], values[keep]
    )
    found = noise.expected(keep, kept.precise(kept.whiten(values[keep])))
    np.testing.assert_allclose(found, expected, atol=1e-10)


def test_spectral_density_is_the_transform_of_the_covariance() -> None:
    frequency, step = np.array([0.0, 0.3, 2.0, 9.0]), 0.05
    lags = np.arange(-4000, 4001) * step
    covariance = 0.7 * np.exp(-np.abs(lags) / 0.1) + 0.3 * np.exp(-np.abs(lags) / 2.0)
    covariance[4000] += 0.5
    expected = np.cos(2.0 * np.pi * np.outer(frequency, lags)) @ covariance
    np.testing.assert_allclose(SPECTRUM.density(frequency, step), expected, rtol=1e-6)


def test_time_constants_go_from_twice_the_step_to_the_whole_span() -> None:
    found = time_constants(0.002, 36.0)
    assert found[0] == pytest.approx(0.004)
    assert found[-1] == pytest.approx(36.0)
    assert np.all(found[1:] / found[:-1] <= 8.0)
    assert time_constants(1.0, 3.0).size == 0


def test_rows_without_any_scatter_have_no_uneven_noise() -> None:
    """A constant error (a sensor that stands) leaves residuals of zero: no group has more noise
    than another, and the logarithm of zero is not taken."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert _scales(np.zeros(300), np.repeat([0, 1, 2], 100), 3) is None


def _scale_of_the_parts(level: np.ndarray, turns: float, seed: int) -> np.ndarray | None:
    """Return the scale of the parts of the turn that is estimated for slow noise with this level
    at each row, in one run of several turns."""
    rows = level.size
    random = np.random.default_rng(seed)
    clock = 2.0 * np.arange(rows)
    whole = RowNoise(clock, np.array([0]), (SLOW,), np.ones(rows))
    residual = level * whole.coloured(random.normal(size=rows))
    channel = ChannelRows(
        "reference",
        clock,
        np.zeros(rows, dtype=np.int64),
        2.0 * np.pi * turns * np.arange(rows) / rows,
        residual,
        np.ones(rows),
        np.zeros((rows, 0)),
        own_constants=False,
    )
    law, _ = estimated_law(channel, FixedTerms(np.zeros((0, 0)), np.zeros(0)), WhiteBounds(0.0))
    return law.angle_scale


def test_a_level_that_changes_with_time_gives_the_parts_of_the_turn_no_scale() -> None:
    """Gusts every 1,600 s triple the noise, at different angles in each turn of 720 s, so that the
    scatter does not depend on the angle."""
    time_s = 2.0 * np.arange(1500)
    gusts = np.where(np.sin(time_s / 260.0) > 0.5, 3.0, 1.0)
    assert _scale_of_the_parts(gusts, 1500.0 / 360.0, seed=5) is None


def test_a_level_that_changes_with_the_angle_gives_the_parts_of_the_turn_their_scale() -> None:
    """A third of the turn has three times the noise, in each of four turns."""
    angle = (np.arange(1500) / 360.0) % 1.0
    scale = _scale_of_the_parts(np.where(angle < 1.0 / 3.0, 3.0, 1.0), 1500.0 / 360.0, seed=6)
    assert scale is not None
    # 12 of the 36 parts have three times the scale of the others; a part has 40 rows, so that its
    # scale is known to 1/√80 = 11 %, and the median of 12 parts to 4 %. The median leaves out the
    # parts with the jumps where the level changes.
    assert np.median(scale[:12]) / np.median(scale[12:]) == pytest.approx(3.0, rel=0.15)


@pytest.mark.parametrize("share", [1e-7, 1e-5, 1e-3, 0.1])
def test_parts_that_are_left_out_hardly_change_the_likelihood(share: float) -> None:
    """The mean log likelihood, from complete covariances, changes by at most NEGLIGIBLE, and the
    variance of a row not at all; a part that changes more stays."""
    rows, step = 600, 0.01
    whole = Spectrum(0.5, time_constants(step, rows * step), np.array([0.7, 1.0, 3.0, 2.0]) * share)
    reduced = whole.without_negligible_parts(rows, step)
    apart = step * np.abs(np.arange(rows)[:, None] - np.arange(rows))
    covariances = [
        item.white * np.eye(rows)
        + sum(
            variance * np.exp(-apart / constant)
            for constant, variance in zip(item.constants, item.variances, strict=True)
        )
        for item in (whole, reduced)
    ]
    # The mean of log p(e | whole) − log p(e | reduced) for noise e of the whole covariance.
    product = np.linalg.solve(covariances[1], covariances[0])
    change = 0.5 * (np.trace(product) - rows - np.linalg.slogdet(product)[1])
    assert reduced.variance == pytest.approx(whole.variance, rel=1e-12)
    assert -1e-9 <= change <= NEGLIGIBLE
    assert (reduced.variances.size < whole.variances.size) == (share < 0.1)
    assert (reduced.variances.size == 0) == (share < 1e-4)
