"""Tests that a fit states no certain value for a parameter that neither rows nor conditions
determine."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arctrue as at
from arctrue.workbench.effects.catalogue.graduation_harmonics import GraduationHarmonics
from arctrue.workbench.effects.catalogue.periodic_error import PeriodicError
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.model.growth import stored_entries
from arctrue.workbench.model.model import ModelEffect
from arctrue.workbench.observations.build import observations_of

FACES, TURNS, NOISE_ARCSEC = 24, 10, 0.1
COUNTS = 1 << 24
FIRST, FIFTH, NINETEENTH = (f"graduation_harmonics.order_{n}_amplitude" for n in (1, 5, 19))
REVERSAL = "hysteresis.reversal_error"
Array = np.ndarray[Any, Any]


def truth_arcsec(angle_deg: Array) -> Array:
    angle = np.deg2rad(angle_deg)
    return np.asarray(2.0 * np.cos(angle) + np.cos(5.0 * angle + 1.0))


@cache
def polygon() -> at.Dataset:
    """Return readings at the faces of a polygon, where the orders 5 and 19 have the same values:
    cos(19·2πk/24) = cos(5·2πk/24)."""
    angle = np.tile(np.arange(FACES) * 360.0 / FACES, TURNS)
    noise = np.random.default_rng(1).normal(0.0, NOISE_ARCSEC, angle.size)
    error = truth_arcsec(angle) + noise
    return at.Dataset.from_arrays(
        reference={"target_deg": angle, "error_arcsec": error},
        faces=FACES,
        counts_per_rev=COUNTS,
    )


def orders(*found: int) -> at.Model:
    return at.Model().having(graduation_harmonics={"orders": list(found)})


@cache
def aliased() -> at.FitResult:
    return at.fit(polygon(), orders(1, 5, 12, 19))


def test_orders_that_alias_at_the_faces_have_no_uncertainty() -> None:
    found = aliased()
    for name in (FIFTH, NINETEENTH, "graduation_harmonics.order_5_phase"):
        assert np.isnan(found.params[name].stderr)
        assert found.params[name].state == "undetermined"
    # The sine of order 12 is 0 at every face.
    assert np.isnan(found.params["graduation_harmonics.order_12_amplitude"].stderr)
    assert found.params[FIRST].state == "free"
    # The amplitude of a cosine in n rows has the standard uncertainty σ·√(2/n).
    expected = NOISE_ARCSEC * np.sqrt(2.0 / (FACES * TURNS))
    assert found.params[FIRST].stderr == pytest.approx(expected, rel=0.2)
    assert found.params[FIFTH].interval() == (0.0, np.inf)
    assert "(not determined)" in str(found.params[FIFTH])
    assert f"warning: the set does not determine {FIFTH}" in found.fit_report()
    assert (FIRST, FIFTH) not in found.correlations
    place = list(found.params).index(FIFTH)
    assert np.isnan(found.covariance[place, place])


def test_a_prediction_between_the_faces_is_uncertain() -> None:
    angle = np.array([0.0, 15.0, 7.5, 22.5])
    value, std = aliased().predict(angle, return_std=True)
    np.testing.assert_allclose(value[:2], truth_arcsec(angle[:2]), atol=4.0 * NOISE_ARCSEC / 3.0)
    assert np.all(np.isfinite(std[:2]))
    assert np.all(np.isinf(std[2:]))
    value, std = at.fit(polygon(), orders(1, 5)).predict(angle, return_std=True)
    assert np.all(np.abs(value - truth_arcsec(angle)) < 4.0 * std)


def test_a_fixed_order_determines_its_alias() -> None:
    """With order 19 fixed at 0, order 5 has the value and the uncertainty of a model without order
    19."""
    found = at.fit(polygon(), orders(1, 5, 19), fix={NINETEENTH: 0.0})
    expected = at.fit(polygon(), orders(1, 5)).params[FIFTH]
    assert found.params[FIFTH].value == pytest.approx(expected.value, abs=0.1 * expected.stderr)
    assert found.params[FIFTH].stderr == pytest.approx(expected.stderr, rel=0.1)
    assert found.params[NINETEENTH].state == "fixed"


def test_an_order_that_the_heads_do_not_show_has_no_uncertainty() -> None:
    """Heads a quarter of a turn apart do not show order 4: cos 4(ψ + 90°) = cos 4ψ."""
    true_arcsec = np.linspace(0.0, 2.2 * 1296000.0, 1500)

    def counts(separation_deg: float) -> Array:
        ring = true_arcsec + 3600.0 * separation_deg
        return np.round((ring + truth_arcsec(ring / 3600.0)) * COUNTS / 1296000.0)

    data = at.Dataset.from_arrays(
        capture={
            "time_s": np.arange(1500) * 0.01,
            "head1_counts": counts(0.0),
            "head2_counts": counts(90.0),
        },
        counts_per_rev=COUNTS,
        head_separation_deg=90.0,
    )
    found = at.fit(data, orders(1, 4))
    fourth = found.params["graduation_harmonics.order_4_amplitude"]
    assert np.isnan(fourth.stderr)
    assert fourth.interval() == (0.0, np.inf)
    assert found.params[FIRST].stderr < 0.1
    _, std = found.predict([0.0, 30.0], return_std=True)
    assert np.all(np.isinf(std))


@pytest.mark.parametrize(
    "rows",
    [
        {"reference": {"target_deg": [0.0], "error_arcsec": [1.0]}},
        {
            "capture": {"time_s": [0.0], "head1_counts": [0], "head2_counts": [1537775]},
            "counts_per_rev": COUNTS,
            "head_separation_deg": 33.0,
        },
    ],
)
def test_one_row_determines_no_order(rows: dict[str, Any]) -> None:
    found = at.fit(at.Dataset.from_arrays(**rows), orders(1, 2))
    assert all(np.isnan(item.stderr) for item in found.params.values())
    assert np.all(np.isinf(found.predict([0.0, 90.0], return_std=True)[1]))
    assert found.nfree == 0


def test_an_export_names_what_its_set_does_not_determine(tmp_path: Path) -> None:
    said = "the set does not determine graduation_harmonics.order_5_amplitude"
    remarks = at.export(polygon(), orders(1, 5, 19), tmp_path / "a.toml", force=True)
    assert any(said in text for text in remarks)
    stored = aliased().model
    assert any(
        said in text for text in at.export(polygon(), stored, tmp_path / "b.toml", force=True)
    )
    remarks = at.export(polygon(), orders(1, 5), tmp_path / "c.toml", force=True)
    assert not any("does not determine" in text for text in remarks)


def test_a_stored_model_has_no_uncertainty_of_a_line_that_only_its_faces_show() -> None:
    """Orders 1 to 12 and the constant fit any 24 values of the faces, so that these values
    determine nothing about a line between them."""
    line = PeriodicError()
    start = {**dict.fromkeys((item.name for item in line.search), 0.0), "order": 7.3}
    terms = [Term(GraduationHarmonics(orders=list(range(1, 13))), {}), Term(line, start)]
    solution = fit(terms, observations_of(polygon()))
    entries = stored_entries([ModelEffect(term.effect.name) for term in terms], solution)
    assert {
        name for name, item in entries[1].parameters.items() if np.isfinite(item.sigma)
    } == set()


@cache
def reversed_runs() -> at.Dataset:
    up = np.arange(FACES) * 15.0
    angle = np.tile(np.concatenate([up, up[::-1]]), 2)
    direction = np.tile(np.repeat([1, -1], FACES), 2)
    noise = np.random.default_rng(4).normal(0.0, NOISE_ARCSEC, angle.size)
    error = 2.0 * np.cos(np.deg2rad(angle) - 0.3) + 0.25 * direction + noise
    return at.Dataset.from_arrays(
        reference={"target_deg": angle, "error_arcsec": error, "direction": direction}
    )


def test_a_reached_bound_is_no_certainty() -> None:
    """A reversal error of 0.5″ is bounded at 0.4″. Its interval ends at the bound, and begins at
    most four standard uncertainties of the fit without a bound below it."""
    model = orders(1).having("hysteresis")
    free = at.fit(reversed_runs(), model).params[REVERSAL]
    found = at.fit(reversed_runs(), model, bounds={REVERSAL: (None, 0.4)})
    held = found.params[REVERSAL]
    assert held.value == pytest.approx(0.4, abs=1e-6)
    assert held.state == "at_bound"
    assert np.isnan(held.stderr)
    low, high = held.interval()
    assert high == 0.4
    assert 0.4 - 4.0 * free.stderr < low < 0.4
    assert "(at a bound)" in found.fit_report()
    assert "(fixed)" not in found.fit_report()
    fixed = at.fit(reversed_runs(), model, fix={REVERSAL: 0.4}).params[REVERSAL]
    assert (fixed.state, fixed.stderr, fixed.interval()) == ("fixed", 0.0, (fixed.value,) * 2)


@pytest.mark.large
def test_an_interval_ends_at_a_bound_that_the_value_does_not_reach() -> None:
    model = orders(1).having("hysteresis")
    free = at.fit(reversed_runs(), model).params[REVERSAL]
    bound = free.value + 0.5 * free.stderr
    held = at.fit(reversed_runs(), model, bounds={REVERSAL: (None, bound)}).params[REVERSAL]
    assert held.state == "free"
    assert held.interval()[1] == pytest.approx(bound, abs=1e-9)


def test_a_tie_to_a_fixed_parameter_fixes_too() -> None:
    model = orders(1, 5)
    found = at.fit(polygon(), model, fix={FIRST: 2.0}, tie={FIFTH: (FIRST, 0.5)})
    assert (found.params[FIFTH].state, found.params[FIFTH].stderr) == ("fixed", 0.0)


def test_a_prediction_contains_the_uncertainty_of_an_order() -> None:
    """Far outside the measured angles, an error of the order δn gives an error A·θ·δn of the
    prediction, which is larger than that of amplitude and phase."""
    random = np.random.default_rng(7)
    angle = np.sort(random.uniform(0.0, 1440.0, 200))

    def truth(at_deg: Array) -> Array:
        return np.asarray(0.6 * np.cos(7.3 * np.deg2rad(at_deg) + 1.0))

    error = truth(angle) + random.normal(0.0, NOISE_ARCSEC, angle.size)
    data = at.Dataset.from_arrays(reference={"target_deg": angle, "error_arcsec": error})
    found = at.fit(data, orders(1).having("periodic_error"))
    order = found.params["periodic_error.order"]
    assert order.value == pytest.approx(7.3, abs=5.0 * order.stderr)
    far = np.array([100.0, 100.03]) * 360.0
    _, std = found.predict(far, return_std=True)
    amplitude = found.params["periodic_error.amplitude"].value
    slope = np.abs(
        amplitude
        * np.deg2rad(far - angle.mean())
        * np.sin(
            order.value * np.deg2rad(far) + np.deg2rad(found.params["periodic_error.phase"].value)
        )
    )
    np.testing.assert_allclose(std, slope * order.stderr, rtol=0.2)
