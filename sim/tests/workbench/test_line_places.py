"""Tests of the search for lines (sine waves) next to integer and half-integer orders and next to
the model's orders."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.workbench.small_sets import (
    CAPTURE_NOISE,
    REFERENCE_NOISE,
    measurement_set,
    paper_error,
)

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.diagnosis import diagnose
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.line_spectrum import LEAST_PERIODS
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.places import LEAST_OWN, Place
from arctrue.workbench.inference.search import places_of
from arctrue.workbench.model.model import default_model
from arctrue.workbench.noise.fit import white_noise
from arctrue.workbench.observations.build import observations_of

Float = NDArray[np.float64]
EFFECTS = built_in()


def _left(measurement: MeasurementSet) -> Residuals:
    observations = observations_of(measurement)
    noise = white_noise(observations, (CAPTURE_NOISE * np.sqrt(2.0), REFERENCE_NOISE))
    term = Term(EFFECTS["graduation_harmonics"](), {})
    return Residuals(fit([term], observations, noise=noise))


def _ball_pass(order: float, size: float = 1.0) -> list[Place]:
    def error(disc: Float, temperature: Float, speed: float) -> Float:
        return paper_error(disc, temperature, speed) + size * np.cos(order * disc + 0.7)

    return places_of(EFFECTS["bearing_ball_pass"](), _left(measurement_set(error)))


def test_a_strong_line_is_found_nearer_to_a_whole_order_than_the_turns_resolve() -> None:
    """The search locates a line of 7 σ per row to about 10⁻⁴ (Rife and Boorstyn), although twelve
    turns resolve only 0.042 of an order."""
    for order in (3.025, 9.53):
        assert abs(_ball_pass(order)[0].nonlinear["order"] - order) < 0.002


def test_a_half_order_is_no_ball_pass() -> None:
    order = _ball_pass(2.5)[0].nonlinear["order"]
    assert abs(order - 2.5) > 1.0 / 24.0


@pytest.mark.large
def test_an_order_that_grows_is_no_vibration_with_it() -> None:
    """The diagnosis names no vibration for an order whose amplitude grows: θ·cos 6θ acts like a
    line next to order 6, and the graduation absorbs most of this line, whatever its size."""

    def error(disc: Float, temperature: Float, speed: float) -> Float:
        return paper_error(disc, temperature, speed) + 0.15 * disc * np.cos(6.0 * disc)

    measurement = measurement_set(error, runs=1, reference=False)
    left = _left(measurement)
    vibration = EFFECTS["vibration"]()
    place = places_of(vibration, left)[0].nonlinear
    assert left.score(vibration, place).own_share > LEAST_OWN
    found = diagnose(observations_of(measurement), default_model().terms(EFFECTS), EFFECTS)
    assert found.verdict == "unknown"
    assert found.described is not None
    assert found.described.effect.parts[:2] == ["time", "order:6"]


def test_less_than_its_fewest_periods_is_no_line() -> None:
    """The search finds no line in a curve with 1.2 periods in the record, which is below the
    searched range."""
    target = np.arange(1080.0)
    time = target / 2.0
    random = np.random.default_rng(5)
    error = 40.0 * np.cos(2.0 * np.pi * 1.2 * time / time[-1]) + random.normal(0.0, 0.2, time.size)
    reference = Reference(
        target_deg=target, error_arcsec=error, time_s=time, run=np.zeros(time.size, dtype=np.int64)
    )
    observations = observations_of(MeasurementSet(Table(), None, reference, title="slow"))
    noise = white_noise(observations, (0.0, 0.2))
    left = Residuals(fit(default_model().terms(EFFECTS), observations, noise=noise))
    place = places_of(EFFECTS["periodic_error"](), left)[0].nonlinear
    periods = place["order"] * 1079.0 / 360.0 + place["frequency"] * time[-1]
    assert periods >= LEAST_PERIODS


def test_a_line_that_is_noise_still_is_found_up_to_where_the_model_takes_it() -> None:
    """The search finds a line that the noise estimate still contains, although the model absorbs
    97 % of this line (order 13.041, runs of three turns). The found order is the first one that the
    search allows.

    At this order the model leaves a twentieth of the power. If the model had order 13 alone, this
    would be δ = 0.042 from order 13 (1 − sinc²(3δ) = 0.05). The other orders of the model make δ
    larger, but not larger than 1/(4·turns) = 0.083.
    """

    def error(disc: Float, temperature: Float, speed: float) -> Float:
        return paper_error(disc, temperature, speed) + np.cos(13.041 * disc + 0.7)

    term = Term(EFFECTS["graduation_harmonics"](), {})
    left = Residuals(fit([term], observations_of(measurement_set(error, seed=3))))
    ball_pass = EFFECTS["bearing_ball_pass"]()
    place = places_of(ball_pass, left)[0].nonlinear["order"]
    assert left.score(ball_pass, {"order": place}).own_share == pytest.approx(LEAST_OWN, abs=5e-3)
    assert 13.041 < place < 13.065
