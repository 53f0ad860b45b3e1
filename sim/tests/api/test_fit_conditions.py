"""Tests that impossible values in ``fix``, ``bounds`` and ``tie`` are refused with a sentence, and
that phases have whole turns."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

import arctrue as at

AMPLITUDE = "graduation_harmonics.order_1_amplitude"
PHASE = "graduation_harmonics.order_1_phase"
TRUE_PHASE_DEG = -17.2
MODEL = at.Model().having(graduation_harmonics={"orders": [1]})


@cache
def data() -> at.Dataset:
    angle = np.tile(np.arange(24) * 15.0, 4)
    error = 2.0 * np.cos(np.deg2rad(angle + TRUE_PHASE_DEG)) + 0.01 * np.sin(np.arange(96))
    return at.Dataset.from_arrays(reference={"target_deg": angle, "error_arcsec": error})


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"fix": {AMPLITUDE: np.nan}}, "fix .*amplitude: expected a finite number, found nan"),
        ({"fix": {AMPLITUDE: np.inf}}, "expected a finite number, found inf"),
        ({"fix": {AMPLITUDE: "a"}}, "expected a finite number, found 'a'"),
        ({"fix": {AMPLITUDE: -1.0}}, "expected 0 or more, found -1"),
        ({"fix": 3}, "fix: expected {name: value} or names, found 3"),
        ({"tie": {AMPLITUDE: lambda _: np.nan}}, "returns a finite number, found nan"),
        ({"tie": {AMPLITUDE: lambda _: "a"}}, "returns a finite number, found 'a'"),
        ({"tie": {AMPLITUDE: AMPLITUDE}}, "expected another parameter"),
        ({"tie": {AMPLITUDE: (PHASE, 1.0, 2.0)}}, r"\(name, factor\) or a function, found"),
        ({"tie": {AMPLITUDE: (PHASE, np.nan)}}, "expected a finite number, found nan"),
        ({"bounds": {AMPLITUDE: 0.5}}, r"expected \(low, high\), None on an open side, found 0.5"),
        ({"bounds": {AMPLITUDE: (np.nan, 1.0)}}, "expected a finite number, found nan"),
        ({"bounds": {AMPLITUDE: (np.inf, None)}}, "expected a finite number, found inf"),
        ({"bounds": {AMPLITUDE: (None, -1.0)}}, "expected 0 or more, found -1"),
        ({"bounds": [AMPLITUDE]}, r"bounds: expected {name: \(low, high\)}"),
    ],
)
def test_a_value_that_no_parameter_can_have_is_refused(options: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        at.fit(data(), MODEL, **options)


def test_an_infinite_bound_is_an_open_side() -> None:
    found = at.fit(data(), MODEL, bounds={AMPLITUDE: (-np.inf, np.inf)})
    assert found.params[AMPLITUDE].value == pytest.approx(2.0, abs=0.01)


@pytest.mark.parametrize("turns", [-1, 0, 1])
def test_bounds_of_a_phase_hold_up_to_whole_turns(turns: int) -> None:
    bounds = (360.0 * turns + TRUE_PHASE_DEG - 20.0, 360.0 * turns + TRUE_PHASE_DEG + 20.0)
    found = at.fit(data(), MODEL, bounds={PHASE: bounds})
    assert found.params[PHASE].value == pytest.approx(TRUE_PHASE_DEG, abs=0.5)
    assert found.params[PHASE].state == "free"


def test_a_phase_ends_at_the_nearer_bound() -> None:
    found = at.fit(data(), MODEL, bounds={PHASE: (300.0, 330.0)})
    assert found.params[PHASE].value == pytest.approx(-30.0, abs=1e-3)
    assert found.params[PHASE].state == "at_bound"
    low, high = found.params[PHASE].interval()
    assert low < high == pytest.approx(-30.0, abs=1e-3)


def test_quantities_are_converted() -> None:
    units = pytest.importorskip("astropy.units")
    found = at.fit(data(), MODEL, fix={AMPLITUDE: 1500.0 * units.mas})
    assert found.params[AMPLITUDE].value == pytest.approx(1.5, abs=1e-6)
    with pytest.raises(ValueError, match="expected a unit that can be converted to arcsec"):
        at.fit(data(), MODEL, fix={AMPLITUDE: 1.5 * units.m})
    free = at.fit(data(), MODEL)
    angle = np.array([0.5, np.pi])
    np.testing.assert_allclose(free.predict(angle * units.rad), free.predict(np.rad2deg(angle)))
    with pytest.raises(ValueError, match="angle: expected a unit that can be converted to deg"):
        free.predict(angle * units.m)


def test_quantities_of_conditions_are_converted() -> None:
    units = pytest.importorskip("astropy.units")
    angle = np.tile(np.arange(24) * 15.0, 4)
    warm = np.repeat([20.0, 21.0, 22.0, 23.0], 24)
    error = (2.0 + 0.5 * (warm - 20.0)) * np.cos(np.deg2rad(angle))
    found = at.fit(
        at.Dataset.from_arrays(
            reference={
                "target_deg": angle,
                "error_arcsec": error + 0.01 * np.sin(np.arange(96)),
                "temperature_c": warm,
            }
        ),
        MODEL.having("thermal_eccentricity"),
    )
    expected = found.predict([10.0], {"temperature_c": 22.0})
    for value in (22.0 * units.deg_C, 295.15 * units.K):
        np.testing.assert_allclose(found.predict([10.0], {"temperature_c": value}), expected)


def test_a_direction_is_plus_or_minus_one() -> None:
    with pytest.raises(ValueError, match=r"condition direction: expected \+1 or -1, found 0.5"):
        at.fit(data(), MODEL).predict([0.0], {"direction": 0.5})


@pytest.mark.parametrize("orders", [[1, 1], [0, 1], [-1, 1], [1.5]])
def test_orders_are_whole_numbers_each_once(orders: list[float]) -> None:
    with pytest.raises(ValueError, match="must list whole numbers above 0, each once"):
        at.Model().having(graduation_harmonics={"orders": orders})


def test_a_model_keeps_its_settings() -> None:
    settings: dict[str, object] = {"orders": [1, 2]}
    model = at.Model().having(graduation_harmonics=settings)
    orders = settings["orders"]
    assert isinstance(orders, list)
    orders.append(7)
    assert model.content.effects[0].settings == {"orders": [1, 2]}


def test_heads_that_are_exchanged_give_a_warning() -> None:
    counts, turns = 1 << 24, np.linspace(0.0, 2.0, 1000)
    heads = [np.round((turns + ahead / 360.0) * counts) for ahead in (33.0, 0.0)]
    swapped = at.Dataset.from_arrays(
        capture={
            "time_s": np.arange(1000) * 0.01,
            "head1_counts": heads[0],
            "head2_counts": heads[1],
        },
        counts_per_rev=counts,
        head_separation_deg=33.0,
    )
    said = "are head1_counts and head2_counts swapped?"
    found = at.fit(swapped, MODEL)
    assert any(said in text for text in found.warnings)
    assert said in found.fit_report()
    assert any(said in text for text in at.compare(swapped, MODEL).warnings)
