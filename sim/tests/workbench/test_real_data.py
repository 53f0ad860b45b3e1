"""Tests that the detections for two measured machines agree with the statements next to the sets in
docs/data."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arctrue.measurement import read_measurement_set
from arctrue.workbench.diagnose.candidates import tried_products
from arctrue.workbench.diagnose.diagnosis import diagnose
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.held_out import held_out
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.search import places_of
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of

DATA = Path(__file__).resolve().parents[3] / "docs" / "data"
EFFECTS = built_in()


@pytest.fixture(scope="module")
def motor() -> Observations:
    return observations_of(read_measurement_set(DATA / "moteus_motor_encoder"))


@pytest.fixture(scope="module")
def axis() -> Observations:
    return observations_of(read_measurement_set(DATA / "worm_axis_telescope"))


def _base() -> Term:
    return Term(EFFECTS["graduation_harmonics"](), {})


def _line(order: int) -> Term:
    place = {"order": float(order), "frequency": 0.0, "in_time": 0.0, "in_capture": 0.0}
    return Term(EFFECTS["periodic_error"](), place)


@pytest.mark.parametrize("name", ["moteus_motor_encoder", "worm_axis_telescope"])
def test_source_and_licence_are_with_the_data(name: str) -> None:
    assert "github.com/" in (DATA / name / "SOURCE.txt").read_text(encoding="utf-8")
    assert (DATA / name / "LICENSE").stat().st_size > 1000


@pytest.mark.large
def test_motor_reversal_error(motor: Observations) -> None:
    """The readings in the two directions differ by 1,200″; the means of the two directions show
    this without a fit."""
    lines = [_line(order) for order in (126, 108, 72, 42)]
    found = diagnose(motor, [_base(), *lines], EFFECTS)
    # All rows have one speed, so that a delay of the reference would look like the reversal error
    # and cannot be tested.
    assert found.verdict == "ambiguous"
    assert found.effect_class == ["hysteresis", "latency"]
    assert found.candidates[0].name == "hysteresis"
    reversal = found.candidates[0].parameters()["reversal_error"].value
    rows = motor.reference
    assert rows is not None
    assert rows.direction is not None
    up = float(np.mean(rows.error_arcsec[rows.direction > 0]))
    down = float(np.mean(rows.error_arcsec[rows.direction < 0]))
    # The fit weights the rows by their noise, which is correlated over the turn, so that the result
    # differs from the plain mean.
    assert reversal == pytest.approx(up - down, rel=0.2)
    assert abs(reversal) == pytest.approx(1200.0, rel=0.2)


@pytest.mark.large
def test_motor_orders_above_the_model(motor: Observations) -> None:
    """The search in the residual finds multiples of the 21 pole pairs and of 36, one after
    another."""
    terms = [_base(), Term(EFFECTS["hysteresis"](), {})]
    effect = EFFECTS["periodic_error"]()
    assert not effect.missing(motor)
    found = []
    for _ in range(7):
        place = places_of(effect, Residuals(fit(terms, motor)))[0]
        assert place.nonlinear["order"] == pytest.approx(round(place.nonlinear["order"]), abs=0.3)
        found.append(round(place.nonlinear["order"]))
        terms.append(Term(effect, place.nonlinear))
    assert found[:4] == [126, 108, 72, 42]
    assert {21, 36, 42, 72} <= set(found)
    assert all(order % 21 == 0 or order % 36 == 0 for order in found)


@pytest.mark.large
def test_motor_is_diagnosed_step_by_step_until_nothing_has_a_name(motor: Observations) -> None:
    """Each step adds the effect that the verdict names: lines at multiples of 21 and of 36, then
    the difference between the directions. At the end an error remains that has no name."""
    terms, named, orders = [_base()], [], []
    for _ in range(12):
        found = diagnose(motor, terms, EFFECTS)
        if found.named is None and not found.decision.look_alikes:
            break
        first = found.candidates[0]
        if found.named is not None and found.detections.without(first.regular).causes:
            assert any("diagnose again" in sentence for sentence in sentences(found))
        named.append(first.name)
        if "order" in first.nonlinear:
            orders.append(round(first.nonlinear["order"]))
        terms.append(first.term)
    assert found.verdict == "unknown"
    assert set(named) <= {"periodic_error", "hysteresis", "reference_drift"}
    assert {"periodic_error", "hysteresis"} <= set(named)
    assert len(set(orders)) >= 4
    assert all(order % 21 == 0 or order % 36 == 0 for order in orders)


@pytest.mark.large
def test_motor_lack_of_fit_is_reported_without_repeats(motor: Observations) -> None:
    """The diagnosis reports the lack of fit that order 126 causes, and names periodic_error,
    although no station repeats."""
    terms = [_base(), Term(EFFECTS["hysteresis"](), {})]
    found = diagnose(motor, terms, EFFECTS)
    lack_of_fit_p = found.channels["reference"].lack_of_fit_p
    assert lack_of_fit_p is not None
    assert lack_of_fit_p < 1e-6
    assert found.named is not None
    assert found.named.name == "periodic_error"


def test_one_head_cannot_know_a_line_of_the_disc(motor: Observations, axis: Observations) -> None:
    for observations in (motor, axis):
        assert EFFECTS["high_order_graduation"]().missing(observations)


@pytest.mark.large
@pytest.mark.parametrize("start", ["graduation_harmonics", "reference_drift"])
def test_the_worm_is_named(axis: Observations, start: str) -> None:
    settings = {"degree": 2} if start == "reference_drift" else {}
    found = diagnose(axis, [Term(EFFECTS[start](**settings), {})], EFFECTS)
    assert found.verdict == "named"
    assert found.named is not None
    assert found.named.name == "drive_gear_error"


def test_the_worm_takes_the_held_out_error(axis: Observations) -> None:
    terms = [Term(EFFECTS["reference_drift"](degree=2), {})]
    before = held_out(terms, axis, fit(terms, axis).context).reference_rms_arcsec
    terms.append(Term(EFFECTS["drive_gear_error"](), {}))
    after = held_out(terms, axis, fit(terms, axis).context).reference_rms_arcsec
    assert before is not None
    assert after is not None
    assert 2.4 < before < 3.2
    assert 0.45 < after < 0.65


@pytest.mark.large
def test_with_the_worm_only_lines_of_its_gears_are_named(axis: Observations) -> None:
    """The diagnosis names only lines of the worm's gears.

    The record covers 9°, so that for example order 30 has only three quarters of a period; a line
    of such a low order would be a slow curve and no property of the axis.
    """
    terms = [
        Term(EFFECTS["reference_drift"](degree=2), {}),
        Term(EFFECTS["drive_gear_error"](), {}),
    ]
    for _ in range(3):
        found = diagnose(axis, terms, EFFECTS)
        if found.named is None:
            break
        order = found.named.parameters()["order"]
        multiple = order.value / 225.0
        assert abs(multiple - round(multiple)) < 3.0 * order.sigma / 225.0
        assert "fixed to the drive" in " ".join(sentences(found))
        terms.append(found.named.term)
    # No remaining product of parts contains an order. A set that can test only a few effects does
    # not get the verdict "adequate".
    assert found.verdict == "cannot_tell"
    assert found.decision.cannot_tell is not None
    assert found.next_measurement is not None
    assert "graduation_harmonics" in found.untestable
    assert found.base is not None
    products = tried_products(Residuals(found.base), 1)
    assert not any(item.effect.orders for item in products)  # type: ignore[attr-defined]
