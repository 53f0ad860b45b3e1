"""Tests of the stated uncertainties of search parameters against the scatter of simulations."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2
from sim.tests.workbench.small_sets import SAMPLES_A_TURN, measurement_set

from arctrue.workbench.effects.base import Parameter
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.change_point import position_sigma_samples
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.search_parameters import refined
from arctrue.workbench.inference.tangents import Tangent
from arctrue.workbench.model.growth import fitted
from arctrue.workbench.model.model import Model, ModelEffect
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()
TURNS = 5
FREQUENCY, ORDER, PLACE, WIDTH, HEIGHT = 7.31, 3.37, 140.0, 1.5, 3.0
TRUTH = {"frequency": FREQUENCY, "order": ORDER, "place": PLACE, "width": WIDTH}


def _error(disc, temperature, speed):  # type: ignore[no-untyped-def]
    # The errors are small, so that reading and true angle differ by little more than 0.001°.
    away = np.degrees((disc - np.radians(PLACE) + np.pi) % (2.0 * np.pi) - np.pi)
    return 1.0 * np.cos(disc) + HEIGHT * np.exp(-0.5 * (away / WIDTH) ** 2)


def _shaken(time, speed):  # type: ignore[no-untyped-def]
    return 0.2 * np.cos(2 * np.pi * FREQUENCY * time + 1.0) + 0.15 * np.cos(ORDER * speed * time)


def _found(seed: int) -> tuple[dict[str, Parameter], list[float]]:
    observations = observations_of(
        measurement_set(_error, seed=seed, runs=1, turns=TURNS, head2_only=_shaken, reference=False)
    )
    start = [
        Term(EFFECTS["graduation_harmonics"](orders=[1, 2, 3]), {}),
        Term(EFFECTS["vibration"](), {"frequency": FREQUENCY * 1.0002}),
        Term(EFFECTS["bearing_ball_pass"](), {"order": ORDER + 0.004}),
        Term(EFFECTS["graduation_defect"](), {"place": PLACE + 0.05, "width": WIDTH * 0.95}),
    ]
    solution = refined(fit(start, observations))
    parameters: dict[str, Parameter] = {}
    for item in solution.parameters()[1:]:
        parameters |= item
    spread = np.sqrt(np.diag(solution._uncertainty[0]))
    height = solution.part(3).start
    return parameters, [float(solution.coefficients[height]), float(spread[height])]


@pytest.mark.large
@pytest.mark.parametrize("repeats", [12, 40])
def test_scatter_is_what_the_linearised_jacobian_says(repeats: int) -> None:
    scaled: dict[str, list[float]] = {name: [] for name in [*TRUTH, "height"]}
    for seed in range(repeats):
        parameters, (height, sigma) = _found(seed)
        for name, true in TRUTH.items():
            scaled[name].append((parameters[name].value - true) / parameters[name].sigma)
        scaled["height"].append((height - HEIGHT) / sigma)
    # Each of the five tests has p = 1/2,000, so that a correct implementation fails for one of 400
    # seeds.
    low, high = chi2.ppf([0.00025, 0.99975], repeats)
    for name, values in scaled.items():
        assert low < float(np.sum(np.square(values))) < high, (name, np.std(values))


def test_tangents_are_the_derivative_of_the_columns() -> None:
    observations = observations_of(measurement_set(runs=1, reference=False))
    term = Term(EFFECTS["graduation_defect"](), {"place": 100.0, "width": 2.0})
    rows = observations.capture
    assert rows is not None
    tangent = Tangent(term, np.array([HEIGHT]), observations)
    found = tangent.capture_columns(rows, {}, fit([], observations).context)
    assert found is not None
    expected = np.zeros_like(found)
    for disc, sign in ((rows.line2_rad, 1.0), (rows.line1_rad, -1.0)):
        away = (np.degrees(disc) - 100.0 + 180.0) % 360.0 - 180.0
        bell = sign * HEIGHT * np.exp(-0.5 * (away / 2.0) ** 2)
        expected[:, 0] += bell * away / 2.0**2
        expected[:, 1] += bell * away**2 / 2.0**3
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max())


@pytest.mark.parametrize("ratio", [0.2, 0.6, 1.1, 2.5])
def test_place_of_a_step_scatters_as_stated(ratio: float) -> None:
    random = np.random.default_rng(5)
    size = int(400 / ratio**2)
    places = []
    for _ in range(1500):
        values = random.normal(0.0, 1.0, size)
        values[size // 2 :] += ratio
        gain = np.cumsum((ratio * (values - 0.5 * ratio))[::-1])[::-1]
        places.append(int(np.argmax(gain)) - size // 2)
    # 1,500 draws from a distribution with heavy tails (kurtosis about 9) determine σ to 4 %.
    assert position_sigma_samples(ratio, 1.0) == pytest.approx(np.std(places), rel=0.15)


@pytest.mark.large
@pytest.mark.parametrize("repeats", [8, 25])
def test_instant_of_a_slip_is_within_its_uncertainty(repeats: int) -> None:
    period = 12.0 / SAMPLES_A_TURN
    scaled = []
    for seed in range(repeats):
        instant = 10.0 + 0.37 * seed
        observations = observations_of(
            measurement_set(
                seed=seed,
                runs=1,
                reference=False,
                head2_only=lambda time, speed, at=instant: 0.35 * (time >= at),  # type: ignore[misc]
            )
        )
        model = Model(
            [
                ModelEffect("graduation_harmonics", {"orders": [1, 2, 3, 5]}),
                ModelEffect("count_slip"),
            ]
        )
        grown, _ = fitted(model, observations, EFFECTS)
        found = grown.effects[1].parameters["instant"]
        # For a step of 0.35″ in noise of 0.15″, σ is below two samples. The stated σ is never
        # smaller than that of a uniform distribution over one sample.
        assert period / np.sqrt(12.0) <= found.sigma < 2.0 * period
        scaled.append((found.value - instant) / found.sigma)
    low, high = chi2.ppf([0.0001, 0.9999], len(scaled))
    assert low < float(np.sum(np.square(scaled))) < high


def test_a_whole_number_is_found_or_not_and_has_no_sigma() -> None:
    def error(disc, temperature, speed):  # type: ignore[no-untyped-def]
        return 50.0 * np.cos(disc) + 0.5 * np.cos(77 * disc)

    observations = observations_of(measurement_set(error, runs=2))
    model = Model([ModelEffect("graduation_harmonics"), ModelEffect("high_order_graduation")])
    grown, solution = fitted(model, observations, EFFECTS)
    assert grown.effects[1].search == {"order": 77.0}
    assert grown.effects[1].parameters["order"].sigma == 0.0
    amplitude = next(
        item for name, item in grown.effects[1].parameters.items() if "amplitude" in name
    )
    assert amplitude.value == pytest.approx(0.5, abs=4.0 * amplitude.sigma)
    assert solution.capture_sigma_arcsec is not None
    assert solution.capture_sigma_arcsec < 0.2
