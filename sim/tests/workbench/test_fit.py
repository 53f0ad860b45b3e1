"""Tests of the fit against numpy's least squares, and of its uncertainties against the scatter of
repeated fits."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.workbench.small_sets import (
    ALPHA,
    CAPTURE_NOISE,
    REFERENCE_NOISE,
    measurement_set,
    paper_error,
)

from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.noise.fit import white_noise
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()


def _graduation() -> Term:
    return Term(EFFECTS["graduation_harmonics"](), {})


def test_capture_alone_is_least_squares_with_the_design_written_out() -> None:
    observations = observations_of(measurement_set(runs=1, reference=False))
    # In this set all rows have equal weights; another test covers weights that follow from the
    # noise.
    noise = white_noise(observations, (CAPTURE_NOISE, None))
    solution = fit([_graduation()], observations, noise=noise)
    rows = observations.capture
    assert rows is not None
    design = [np.ones(rows.angle_rad.size)]
    for order in range(1, 21):
        for wave in (np.cos, np.sin):
            design.append(wave(order * (rows.angle_rad + ALPHA)) - wave(order * rows.angle_rad))
    expected, *_ = np.linalg.lstsq(np.stack(design, axis=1), rows.difference_arcsec, rcond=None)
    # The prior of the run's offset changes only the constant, by less than 0.001 of the constant's
    # uncertainty.
    np.testing.assert_allclose(solution.coefficients, expected[1:], atol=1e-6)


def test_noise_of_both_channels_and_the_truth_are_found() -> None:
    solution = fit([_graduation()], observations_of(measurement_set()))
    # The difference has the noise of two heads and the rounding of both heads to whole counts of
    # 0.0772″.
    both_heads = np.sqrt(2.0 * (CAPTURE_NOISE**2 + 0.0772**2 / 12.0))
    assert solution.capture_sigma_arcsec == pytest.approx(both_heads, rel=0.03)
    assert solution.reference_sigma_arcsec == pytest.approx(REFERENCE_NOISE, rel=0.15)
    disc = np.linspace(0.0, 2.0 * np.pi, 100)
    found = solution.context.error_arcsec(disc)
    left = found - paper_error(disc, disc, 0.0)
    # At 33° the heads magnify the noise of order 11 by a factor of 19; the reference run determines
    # this order.
    assert np.max(np.abs(left - left.mean())) < 0.05


@pytest.mark.large
def test_covariance_is_that_of_repetition() -> None:
    draws = []
    sigma = None
    for seed in range(40):
        solution = fit(
            [_graduation()], observations_of(measurement_set(seed=seed, runs=2, cycles=2))
        )
        draws.append(solution.coefficients[:10])
        sigma = np.sqrt(np.diag(solution.covariance))[:10]
    assert sigma is not None
    ratio = np.std(draws, axis=0, ddof=1) / sigma
    # 40 draws determine one standard deviation to 11 %, and the mean of 10 standard deviations to 4
    # %.
    assert np.mean(ratio) == pytest.approx(1.0, abs=0.12)


def test_blind_order_is_left_at_zero_not_blown_up() -> None:
    effect = EFFECTS["graduation_harmonics"](orders=[1, 2, 3, 4, 5, 120])
    observations = observations_of(measurement_set(runs=1, reference=False))
    solution = fit([Term(effect, {})], observations)
    assert np.max(np.abs(solution.coefficients[-2:])) < 1e-6
    assert solution.rank == 10 + 1


def test_two_effects_of_one_name_have_their_own_columns() -> None:
    """Two effects with the same name and settings have their own columns, as after a user has
    changed the file of an effect and loaded it again. Columns twice as large need coefficients half
    as large."""
    kind = EFFECTS["graduation_harmonics"]

    class Doubled(kind):  # type: ignore[misc, valid-type]
        def capture_columns(self, *arguments: object) -> np.ndarray:
            return 2.0 * super().capture_columns(*arguments)

    observations = observations_of(measurement_set(runs=1, turns=1, reference=False))
    noise = white_noise(observations, (CAPTURE_NOISE, None))
    once = fit([Term(kind(), {})], observations, noise=noise)
    twice = fit([Term(Doubled(), {})], observations, noise=noise)
    np.testing.assert_allclose(2.0 * twice.coefficients, once.coefficients, rtol=1e-9, atol=1e-12)
