"""Tests that ``arctrue.fit`` agrees with least squares, with scipy's optimisers, and with the
equation of the model."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.optimize import curve_fit, least_squares
from scipy.stats import t as student

import arctrue as at
from arctrue.api.results import numbered
from arctrue.workbench.inference.profile import Profile

FACES, CYCLES, NOISE_ARCSEC = 24, 8, 0.2
TRUE = {"c1": 2.0, "s1": -0.5, "c3": 0.0, "s3": 0.3, "hysteresis": 0.4}
COLOURED_SHARE = 0.15
"""Relative tolerance of the uncertainties; in 192 rows of white noise the fit also finds a small
correlated part, which changes them."""
NEAR_ARCSEC = 0.5 * NOISE_ARCSEC * np.sqrt(2.0 / (FACES * CYCLES))
"""Tolerance of the values: half the standard uncertainty of an amplitude."""
Array = np.ndarray[Any, Any]


@cache
def columns() -> dict[str, Array]:
    """Return the columns of a reference run. The stations are in random order, so that slow noise
    is not correlated with the effects."""
    random = np.random.default_rng(20260)
    angle = random.permutation(np.tile(np.arange(FACES) * 360.0 / FACES, CYCLES))
    direction = random.permutation(np.repeat([-1, 1], angle.size // 2))
    phase = np.deg2rad(angle)
    error = (
        TRUE["c1"] * np.cos(phase)
        + TRUE["s1"] * np.sin(phase)
        + TRUE["s3"] * np.sin(3.0 * phase)
        + 0.5 * TRUE["hysteresis"] * direction
        + random.normal(0.0, NOISE_ARCSEC, angle.size)
    )
    return {"target_deg": angle, "error_arcsec": error, "direction": direction}


def data() -> at.Dataset:
    return at.Dataset.from_arrays(reference=columns(), faces=FACES)


def harmonics(*orders: int) -> at.Model:
    return at.Model().having(graduation_harmonics={"orders": list(orders)})


@cache
def fitted() -> at.FitResult:
    return at.fit(data(), harmonics(1, 3).having("hysteresis"))


def design() -> Array:
    """Return the design matrix of the model of :func:`columns`, written from its equation."""
    phase = np.deg2rad(columns()["target_deg"])
    waves = [function(n * phase) for n in (1, 3) for function in (np.cos, np.sin)]
    return np.stack([*waves, 0.5 * columns()["direction"], np.ones(phase.size)], axis=1)


def ordinary() -> tuple[Array, Array]:
    """Return the coefficients of ordinary least squares, and their covariance from the
    residuals."""
    matrix, error = design(), columns()["error_arcsec"]
    found, rest, *_ = np.linalg.lstsq(matrix, error)
    variance = rest[0] / (error.size - matrix.shape[1])
    return found, variance * np.linalg.inv(matrix.T @ matrix)


def test_values_and_uncertainties_are_those_of_least_squares() -> None:
    found, covariance = ordinary()
    params = fitted().params
    size = params["hysteresis.reversal_error"]
    assert size.value == pytest.approx(found[4], abs=NEAR_ARCSEC)
    amplitude = params["graduation_harmonics.order_1_amplitude"]
    assert amplitude.value == pytest.approx(np.hypot(found[0], found[1]), abs=NEAR_ARCSEC)
    along = found[:2] / np.hypot(*found[:2])
    expected = np.sqrt(along @ covariance[:2, :2] @ along)
    assert amplitude.stderr == pytest.approx(expected, rel=COLOURED_SHARE)
    assert (amplitude.unit, size.unit) == ("arcsec", "arcsec")


@pytest.mark.large
def test_an_interval_in_white_noise_is_students() -> None:
    """In white noise the half-widths of a linear parameter's interval agree, within 15 %, with
    those of Student's t."""
    amplitude = fitted().params["graduation_harmonics.order_1_amplitude"]
    freedom = data().reference.error_arcsec.size - 6  # type: ignore[union-attr]
    for level in (0.68, 0.95):
        low, high = amplitude.interval(level)
        half = student.ppf(0.5 + 0.5 * level, freedom) * amplitude.stderr
        assert low == pytest.approx(amplitude.value - half, abs=COLOURED_SHARE * half)
        assert high == pytest.approx(amplitude.value + half, abs=COLOURED_SHARE * half)
    with pytest.raises(ValueError, match="level: expected a number between 0 and 1, found 95"):
        amplitude.interval(95)


@pytest.mark.large
def test_an_amplitude_within_its_noise_reaches_down_to_zero() -> None:
    found = at.fit(data(), harmonics(1, 2, 3))
    low, high = found.params["graduation_harmonics.order_2_amplitude"].interval(0.95)
    assert low == 0.0
    assert 0.0 < high < 5.0 * NOISE_ARCSEC / np.sqrt(FACES * CYCLES / 2.0)


def conditioned(**options: Any) -> at.FitResult:
    return at.fit(data(), harmonics(1, 3), **options)


def least(of: Any, start: list[float], **options: Any) -> Array:
    """Fit the equation of :func:`columns` with scipy's least squares; the constant is the last
    unknown."""
    phase, error = np.deg2rad(columns()["target_deg"]), columns()["error_arcsec"]

    def rest(unknown: Array) -> Array:
        c1, s1, c3, s3, constant = of(unknown)
        model = c1 * np.cos(phase) + s1 * np.sin(phase) + c3 * np.cos(3 * phase)
        return np.asarray(model + s3 * np.sin(3 * phase) + constant - error)

    return np.asarray(least_squares(rest, start, xtol=1e-12, ftol=1e-12, **options).x)


def test_a_fixed_amplitude_leaves_its_phase_free() -> None:
    name = "graduation_harmonics.order_1_amplitude"
    found = conditioned(fix={name: 1.8})
    assert found.params[name].value == pytest.approx(1.8, abs=1e-6)
    assert found.params[name].stderr == 0.0
    assert found.params[name].interval() == (found.params[name].value,) * 2
    expected = least(
        lambda u: (1.8 * np.cos(u[0]), -1.8 * np.sin(u[0]), u[1], u[2], u[3]), [0.2, 0, 0.3, 0]
    )
    phase = found.params["graduation_harmonics.order_1_phase"]
    assert phase.value == pytest.approx(np.degrees(expected[0]), abs=np.degrees(NEAR_ARCSEC / 1.8))
    assert 0.0 < phase.stderr < 2.0
    third = found.params["graduation_harmonics.order_3_amplitude"]
    assert third.value == pytest.approx(np.hypot(expected[1], expected[2]), abs=NEAR_ARCSEC)
    assert "(fixed)" in found.fit_report(min_correl=0.0)
    assert not any(name in pair for pair in found.correlations)
    assert not found.covariance[list(found.params).index(name)].any()


def test_a_bound_holds_and_another_one_does_nothing() -> None:
    name = "graduation_harmonics.order_3_amplitude"
    free = conditioned()
    held = conditioned(bounds={name: (None, 0.2), "graduation_harmonics.order_1_amplitude": (0, 9)})
    assert held.params[name].value == pytest.approx(0.2, abs=1e-5)
    expected = least(
        lambda u: (u[0], u[1], u[2] * np.cos(u[3]), -u[2] * np.sin(u[3]), u[4]),
        [2.0, -0.5, 0.1, -1.5, 0.0],
        bounds=([-9, -9, 0, -9, -9], [9, 9, 0.2, 9, 9]),
    )
    assert held.params["graduation_harmonics.order_3_phase"].value == pytest.approx(
        np.degrees(expected[3]), abs=np.degrees(NEAR_ARCSEC / 0.2)
    )
    wide = conditioned(bounds={name: (0.0, 5.0)})
    for one in free.params:
        assert wide.params[one].value == pytest.approx(free.params[one].value, abs=1e-3)


def test_tied_parameters_move_together() -> None:
    first, third = (f"graduation_harmonics.order_{n}_amplitude" for n in (1, 3))
    found = conditioned(tie={third: (first, 0.1)})
    values = found.params.valuesdict()
    assert values[third] == pytest.approx(0.1 * values[first], abs=1e-6)
    expected = least(
        lambda u: (
            u[0] * np.cos(u[1]), -u[0] * np.sin(u[1]),
            0.1 * u[0] * np.cos(u[2]), -0.1 * u[0] * np.sin(u[2]), u[3],
        ),
        [2.0, 0.2, -1.5, 0.0],
    )  # fmt: skip
    assert values[first] == pytest.approx(expected[0], abs=NEAR_ARCSEC)
    same = conditioned(tie={third: lambda p: 0.1 * p[first]})
    assert same.params.valuesdict() == pytest.approx(values, abs=1e-4)
    assert found.solution.rank == conditioned().solution.rank - 1


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"fix": {"graduation_harmonics.order_1_amplitud": 1.0}}, "Did you mean graduation_h"),
        (
            {"fix": ["graduation_harmonics.order_1_phase"]},
            "the model has no fitted value for this name",
        ),
        ({"bounds": {"graduation_harmonics.order_1_phase": (5.0, 1.0)}}, "expected low <= high"),
        ({"tie": {"graduation_harmonics.order_1_phase": "no"}}, "no parameter 'no'"),
        (
            {
                "fix": {"graduation_harmonics.order_1_amplitude": 1.0},
                "bounds": {"graduation_harmonics.order_1_amplitude": (2.0, None)},
            },
            "no values meet the condition together with the others",
        ),
    ],
)
def test_conditions_that_cannot_be_are_refused(options: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        conditioned(**options)


def test_fixed_names_keep_what_an_earlier_fit_found() -> None:
    before = conditioned()
    name = "graduation_harmonics.order_1_amplitude"
    again = at.fit(data(), before.model, fix=[name])
    assert again.params[name].value == pytest.approx(before.params[name].value, abs=1e-6)


def test_correlations_are_those_of_the_covariance() -> None:
    """Readings at only half of the faces correlate orders 1 and 3; scipy computes the same
    correlation."""
    rows = np.deg2rad(columns()["target_deg"]) < np.pi
    half = {name: values[rows] for name, values in columns().items() if name != "direction"}
    found = at.fit(at.Dataset.from_arrays(reference=half), harmonics(1, 3))
    phase = np.deg2rad(half["target_deg"])

    def model(_: Array, a1: float, p1: float, a3: float, p3: float, constant: float) -> Array:
        return np.asarray(a1 * np.cos(phase + p1) + a3 * np.cos(3 * phase + p3) + constant)

    _, covariance = curve_fit(model, phase, half["error_arcsec"], p0=[2, 0.2, 0.3, -1.5, 0])
    spread = np.sqrt(np.diag(covariance))
    expected = covariance / np.outer(spread, spread)
    names = list(found.params)
    for i in range(4):
        for j in range(i):
            assert found.correlations[names[i], names[j]] == pytest.approx(expected[i, j], abs=0.1)
    assert found.covariance.shape == (4, 4)


def test_the_prediction_is_the_equation() -> None:
    found = fitted()
    angle = np.linspace(-30.0, 400.0, 77)
    coefficients, covariance = ordinary()
    waves = [f(n * np.deg2rad(angle)) for n in (1, 3) for f in (np.cos, np.sin)]
    for direction in (1, -1):
        matrix = np.stack([*waves, np.full(angle.size, 0.5 * direction)], axis=1)
        expected = matrix @ coefficients[:5]
        value, std = found.predict(angle, {"direction": direction}, return_std=True)
        np.testing.assert_allclose(value, expected, atol=2.0 * NEAR_ARCSEC)
        spread = np.sqrt(np.einsum("ij,jk,ik->i", matrix, covariance[:5, :5], matrix))
        np.testing.assert_allclose(std, spread, rtol=COLOURED_SHARE)
    with pytest.raises(ValueError, match=r"hysteresis needs direction: predict\(angle, {'direct"):
        found.predict(angle)
    with pytest.raises(ValueError, match=r"condition temprature_c is not known. Did you mean temp"):
        found.predict(angle, {"temprature_c": 20.0})
    with pytest.raises(ValueError, match="expected one number or 77"):
        found.predict(angle, {"direction": [1, -1]})


def test_residuals_and_report() -> None:
    found = fitted()
    coefficients, _ = ordinary()
    expected = columns()["error_arcsec"] - design() @ coefficients
    np.testing.assert_allclose(found.residuals()["reference"], expected, atol=4.0 * NEAR_ARCSEC)
    white = found.residuals(whitened=True)["reference"]
    # Only n − p residuals are independent, so that the mean square is (n − p)/n ± √(2/n).
    assert white @ white / white.size == pytest.approx(1.0, abs=3.0 * np.sqrt(2.0 / white.size))
    report = found.fit_report()
    assert "192 rows" in report
    for name, item in found.params.items():
        assert f"{name}" in report
        assert str(item) in report
    assert "order_1_amplitude" in found._repr_html_()
    with pytest.raises(KeyError, match="Did you mean"):
        found.params["hysteresis.reversal_erro"]


def test_two_models_of_one_set() -> None:
    small, large = conditioned(), fitted()
    found = at.compare_models(small, large)
    assert found.ratio is not None
    # The expected gain follows from the residual sums of squares without and with the further
    # column.
    error, matrix = columns()["error_arcsec"], design()
    rest = [float(np.linalg.lstsq(part, error)[1][0]) for part in (np.delete(matrix, 4, 1), matrix)]
    free = error.size - matrix.shape[1]
    expected = (free + 1) * np.log(rest[0] / rest[1])
    assert found.ratio.gain == pytest.approx(expected, rel=0.1)
    assert (found.ratio.parameters, found.ratio.larger) == (1, 2)
    assert found.ratio.p_value < 1e-6
    assert found.bic_difference == pytest.approx(found.ratio.gain - np.log(error.size), rel=0.15)
    fall, uncertainty = found.held_out_fall_arcsec["reference"]
    assert fall > 3.0 * uncertainty > 0.0
    # p is below 1e-9, the smallest value that is printed.
    assert "with 1 parameters, p < 1e-9\n" in str(found)
    back = at.compare_models(large, small)
    assert back.ratio is not None
    assert back.ratio.larger == 1
    assert back.bic_difference == -found.bic_difference
    assert at.compare_models(conditioned(), at.fit(data(), harmonics(1, 2))).ratio is None
    other = {**columns(), "error_arcsec": columns()["error_arcsec"] + 1e-3 * np.arange(192)}
    with pytest.raises(ValueError, match="use different rows of the reference"):
        at.compare_models(small, at.fit(at.Dataset.from_arrays(reference=other), harmonics(1)))


def test_the_fit_is_a_step_of_the_history() -> None:
    found = fitted()
    (step,) = found.model.history
    assert (step.action, step.measurement_sha256) == ("fit", data().sha256)
    assert step.rms_arcsec["reference"] == pytest.approx(found.left.rms_arcsec["reference"])


def test_a_model_is_meant_in_several_ways(tmp_path: Any) -> None:
    at.write_set(tmp_path / "set", data())
    found = at.fit(str(tmp_path / "set"), ["hysteresis"])
    assert found.model.effects == ["graduation_harmonics", "hysteresis"]
    found.model.write(tmp_path / "m.toml")
    again = at.fit(tmp_path / "set", tmp_path / "m.toml")
    assert again.params.valuesdict() == pytest.approx(found.params.valuesdict(), abs=1e-3)
    with pytest.raises(TypeError, match="expected a Model, the name of a model file"):
        at.fit(tmp_path / "set", 3)  # type: ignore[arg-type]


def test_the_pictures_of_a_fit_are_those_of_its_comparison() -> None:
    pytest.importorskip("matplotlib")
    model = harmonics(1, 3).having("hysteresis")
    found, compared = fitted().plot(), at.compare(data(), model).plot()
    assert found.images.keys() == compared.images.keys() != set()
    assert all(image.startswith(b"\x89PNG") for image in found.images.values())


def test_an_effect_that_is_added_twice_keeps_both_sizes() -> None:
    sizes = numbered([("periodic_error", 3.0), ("hysteresis", 2.0), ("periodic_error", 1.0)])
    assert sizes == {"periodic_error": 3.0, "hysteresis": 2.0, "periodic_error (2)": 1.0}


@pytest.mark.large
def test_an_explanation_names_the_cause_with_its_size() -> None:
    """The explanation names the simulated reversal error with its size, 0.25″ in each direction."""
    table = at.simulate("hysteresis", sizes=[0.5], experiment="short", seed=3)
    found = at.explain(table)
    assert found.model.effects == ["graduation_harmonics", "hysteresis"]
    assert found.sizes_arcsec["hysteresis"] == pytest.approx(0.25, abs=0.03)
    assert found.verdict.verdict == "adequate"
    assert [step.action for step in found.model.history] == ["fit", "add"]
    assert all(step.measurement_sha256 == table.sha256 for step in found.model.history)


@pytest.mark.parametrize("gain", [0.05, 1.5])
def test_an_interval_whose_likelihood_is_found_in_steps_has_ends(
    monkeypatch: pytest.MonkeyPatch, gain: float
) -> None:
    """If a search for the noise begins at a better start, it finds a higher likelihood at the same
    value. Here the likelihood is a parabola, whose ends are known, and rises three times by
    ``gain``, after every ninth evaluation."""
    angle = np.tile(np.arange(24) * 15.0, 4)
    error = 2.0 * np.cos(np.deg2rad(angle)) + 0.1 * np.sin(np.arange(96.0) ** 2)
    data = at.Dataset.from_arrays(reference={"target_deg": angle, "error_arcsec": error})
    item = at.fit(data, at.Model().having(graduation_harmonics={"orders": [1]})).params[
        "graduation_harmonics.order_1_amplitude"
    ]
    calls = 0

    def in_steps(self: Profile, conditions: Any, start: Any) -> tuple[float, Any]:
        nonlocal calls
        calls += 1
        value = -conditions[-1].difference({item.name: 0.0})
        return -0.5 * ((value - item.value) / item.stderr) ** 2 + gain * min(calls // 9, 3), start

    monkeypatch.setattr(Profile, "_fixed_terms", in_steps)
    low, high = item.interval(0.95)
    # The steps may move the ends inwards; the bound allows 5 % outwards.
    reach = student.ppf(0.975, 90) * item.stderr
    assert item.value - 1.05 * reach <= low <= item.value <= high <= item.value + 1.05 * reach


@pytest.mark.large
def test_the_interval_of_a_thermal_eccentricity_has_ends() -> None:
    """The restricted likelihood of these 12,480 rows with slow noise has an error of about 0.04.
    Each end of the interval is 1.96 standard uncertainties from the value, within 0.2 of one."""
    data = at.simulate("thermal_eccentricity", experiment="short", seed=2)
    item = at.fit(data, ["thermal_eccentricity"]).params["thermal_eccentricity.amplitude"]
    low, high = item.interval(0.95)
    assert low == pytest.approx(item.value - 1.96 * item.stderr, abs=0.2 * item.stderr)
    assert high == pytest.approx(item.value + 1.96 * item.stderr, abs=0.2 * item.stderr)
