"""Tests of score tests: several effects at once, maxima between grid points, and the noise that a
score estimates anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sim.tests.workbench.small_sets import Float, measurement_set, paper_error

from arctrue.workbench.diagnose.parts_scan import best_parts
from arctrue.workbench.effects.part_conditions import TEMPERATURE
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term, channel_columns
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.likelihood_ratio import under
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.maximum import moved_to_maximum
from arctrue.workbench.inference.scan.places import Place
from arctrue.workbench.noise.fit import white_noise
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()
OBSERVATIONS = observations_of(measurement_set())
SOLUTION = fit([Term(EFFECTS["graduation_harmonics"](), {})], OBSERVATIONS)


def test_scores_of_several_effects_are_those_of_each_alone() -> None:
    """The scores of several effects equal those of each effect alone; the effects act in one
    channel or in both, and together have more columns than one group can hold."""
    names = ["hysteresis", "polygon_face_error", "subdivision_error", "thermal_head_drift"]
    asked = [(EFFECTS[name](), {}) for name in names]
    asked += [
        (EFFECTS["vibration"](), {"frequency": frequency}) for frequency in (3.0, 7.5, 11.0, 20.0)
    ]
    together = Residuals(SOLUTION).scores(asked)
    for (effect, place), found in zip(asked, together, strict=True):
        alone = Residuals(SOLUTION).score(effect, place)
        assert found.rank == alone.rank
        assert found.gain == pytest.approx(alone.gain, rel=1e-9)
        np.testing.assert_allclose(found.coefficients, alone.coefficients, rtol=1e-6, atol=1e-12)


def test_score_is_the_fall_of_generalised_least_squares() -> None:
    """The score equals the fall of χ² when the columns are added, computed from dense covariance
    matrices."""
    residuals = Residuals(SOLUTION)
    effect = EFFECTS["thermal_head_drift"]()
    score = residuals.score(effect, {})
    design = residuals._designs[0]
    of_rows = SOLUTION.noise.capture
    assert design is not None
    assert of_rows is not None
    columns = channel_columns([Term(effect, {})], OBSERVATIONS, SOLUTION.context, capture=True)
    further = of_rows.whiten(columns)
    information = further.T @ further
    cross = np.zeros((residuals._layout.size, columns.shape[1]))
    cross[residuals._layout.capture()] = np.vstack(
        [
            design.columns.T @ further,
            [
                design.ones[design.offset == run] @ further[design.offset == run]
                for run in range(design.offsets)
            ],
        ]
    )
    information = information - cross.T @ np.linalg.pinv(residuals._normal) @ cross
    whitened = residuals.capture_whitened
    assert whitened is not None
    moment = further.T @ whitened
    assert score.gain == pytest.approx(float(moment @ np.linalg.solve(information, moment)), 1e-6)


def test_a_score_with_columns_that_moved_with_the_model_is_that_of_a_fit() -> None:
    """The score equals the fall of χ² in a fit, also if columns have changed with the model. A
    scale error of 1 % changes ε and therefore the column of the scale error, so that the residual
    is not that of a least-squares fit.

    The column of the scale error contains order 1 and leaves only 1 % of one direction of order 1;
    in this direction a small residual would look like a large wave. The score and the fit are
    compared with the same noise and the same ε.
    """
    measurement = measurement_set(turns=1, runs=1)
    assert measurement.reference is not None
    measurement.reference.error_arcsec[:] *= 1.01
    observations = observations_of(measurement)
    first = Residuals(fit([Term(EFFECTS["graduation_harmonics"](), {})], observations))
    gain, wave = EFFECTS["autocollimator_gain"](), EFFECTS["polygon_eccentricity"]()
    grown = first.solution_with(gain, {}, first.score(gain, {}))
    again = fit(grown.terms, observations, grown.context, noise=grown.noise)
    found, expected = (
        Residuals(replace(solution, context=grown.context)).score(wave, {})
        for solution in (grown, again)
    )
    assert found.gain == pytest.approx(expected.gain, rel=1e-6)
    assert found.gain < 12.0  # χ² of two columns exceeds this in 1 of 400 sets


@pytest.mark.parametrize("away", [-0.7, 0.0, 0.4, 2.6])
def test_a_line_is_found_between_and_beyond_the_points_of_a_grid(away: float) -> None:
    """The search finds a sine between and beyond the points of its grid; the grid has steps of a
    quarter of the record's resolution, and the tolerance is a twentieth of a step."""
    rows = OBSERVATIONS.capture
    assert rows is not None
    step = 0.25 / OBSERVATIONS.longest_run_s
    true = 7.0 + away * step
    line = 3.0 * np.sin(2.0 * np.pi * true * rows.time_s)
    left = Residuals(SOLUTION).with_residuals(line, np.zeros(OBSERVATIONS.reference.run.size))  # type: ignore[union-attr]
    effect = EFFECTS["vibration"]()
    begin = Place({"frequency": 7.0}, left.score(effect, {"frequency": 7.0}).gain, 1.0)
    found = moved_to_maximum(effect, left, [begin], "frequency", step)[0]
    dense = [
        left.score(effect, {"frequency": found.nonlinear["frequency"] + move * step}).gain
        for move in (-0.02, 0.02)
    ]
    assert found.gain >= max(dense)
    assert found.nonlinear["frequency"] == pytest.approx(true, abs=0.05 * step)


def test_noise_of_a_channel_that_an_effect_does_not_touch_stays() -> None:
    """The noise is estimated anew only for the channel that the effect changes."""
    turned = observations_of(measurement_set(reversal_arcsec=1.0))
    solution = fit(SOLUTION.terms, turned)
    residuals = Residuals(solution)
    effect = EFFECTS["hysteresis"]()
    grown = residuals.solution_with(effect, {}, residuals.score(effect, {}))
    noise = under(grown, solution)
    assert noise.capture is solution.noise.capture
    assert noise.reference is not None
    assert solution.noise.reference is not None
    assert noise.reference.rms_arcsec < 0.5 * solution.noise.reference.rms_arcsec


@pytest.mark.large
def test_scales_that_a_missing_effect_made_go_with_it() -> None:
    """The scales that a missing effect caused become 1 with the effect in the model: an effect of
    2″/K increases the scatter of the only warm run.

    The score test's estimate of the noise with the effect equals that of a fit with the effect
    within 1 %; 14,400 rows determine it to 1/√(2·14,400) = 0.6 %.
    """

    def warm(disc: Float, temperature: Float, speed: float) -> Float:
        return paper_error(disc, temperature, speed) + 2.0 * (temperature - 20.0) * np.cos(
            25.0 * disc
        )

    solution = fit(SOLUTION.terms, observations_of(measurement_set(warm)))
    residuals = Residuals(solution)
    part = ProductOfParts.of(TEMPERATURE, (25.0,), "disc")
    grown = residuals.solution_with(part, {}, residuals.score(part, {}))
    assert solution.noise.capture_law is not None
    assert solution.noise.capture_law.run_scale[3] > 2.0
    found, alone = under(grown, solution), fit(grown.terms, solution.observations).noise
    assert found.capture_law is not None
    np.testing.assert_allclose(found.capture_law.run_scale, 1.0)
    assert found.capture is not None
    assert alone.capture is not None
    assert found.capture.rms_arcsec == pytest.approx(alone.capture.rms_arcsec, rel=0.01)


def test_products_of_parts_are_looked_for_at_every_half_order() -> None:
    """The search tries products of parts at every half order: the first product that it finds is a
    wave of order 12.5."""
    rows = OBSERVATIONS.capture
    assert rows is not None
    wave = SOLUTION.noise.capture.draw(np.random.default_rng(2))  # type: ignore[union-attr]
    wave = wave + 0.5 * np.cos(12.5 * rows.angle_rad + 0.3)
    left = Residuals(SOLUTION).with_residuals(wave, np.zeros(OBSERVATIONS.reference.run.size))  # type: ignore[union-attr]
    assert best_parts(left)[0].effect.orders == (12.5,)


@pytest.mark.parametrize("order", [48.3072, 200.3])
def test_noise_of_the_angles_explains_no_noise_of_the_rows(order: float) -> None:
    """Noise of the angles must not explain noise of the rows: with an error for each face in the
    model, only the noise of the angles remains of any wave over the stations.

    The two columns in the capture remain; in white noise their gain exceeds 18.4 in 1 of 10⁴ sets.
    """
    observations = observations_of(measurement_set(runs=1, cycles=6))
    model = [Term(EFFECTS[name](), {}) for name in ("graduation_harmonics", "polygon_face_error")]
    noise = white_noise(observations, (0.1 * np.sqrt(2.0), 0.15))
    residuals = Residuals(fit(model, observations, noise=noise))
    found = residuals.score(EFFECTS["bearing_ball_pass"](), {"order": order})
    assert found.rank == 2
    assert found.gain < 18.4


def test_a_score_with_coefficients_away_from_the_maximum_is_that_of_the_fit() -> None:
    """The score equals the fall of χ² in a fit, also if it drops directions of the effect that the
    model explains: the face errors explain two of the effect's four columns.

    Without a column that depends on the model, the score test is quadratic, so that the values of
    the model's coefficients have no influence.
    """
    observations = observations_of(measurement_set(runs=1, cycles=6))
    model = [Term(EFFECTS[name](), {}) for name in ("graduation_harmonics", "polygon_face_error")]
    noise = white_noise(observations, (0.1 * np.sqrt(2.0), 0.15))
    solution = fit(model, observations, noise=noise)
    away = replace(solution, coefficients=solution.coefficients + 0.01)
    found, expected = (
        Residuals(one).score(EFFECTS["bearing_ball_pass"](), {"order": 48.3072})
        for one in (away, solution)
    )
    assert found.rank == 2
    np.testing.assert_allclose(found.moment, expected.moment, rtol=0.0, atol=1e-6)
    assert found.gain == pytest.approx(expected.gain, rel=1e-6)
