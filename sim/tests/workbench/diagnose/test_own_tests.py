"""Tests that causes outside the catalogue, written from the physics, get no name although they look
like an effect."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet
from arctrue.workbench.diagnose.own_tests import one_pattern
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.small_sets import measurement_set, paper_error


@pytest.mark.parametrize("pairs", [6, pytest.param(7, marks=pytest.mark.large)])
def test_a_disc_written_in_sectors_is_no_single_order(pairs: int) -> None:
    """Every second sector has an error of 0.8″: a square wave, with 3, 5 and 7 times its order."""

    def error(disc: np.ndarray, temperature: np.ndarray, speed: float) -> np.ndarray:
        return paper_error(disc, temperature, speed) + 0.4 * np.sign(np.sin(pairs * disc + 0.3))

    found = diagnosis_of(measurement_set(error, seed=2, reference=False))
    assert found.verdict == "unknown"
    assert found.decision.resembles is not None
    assert found.decision.resembles.name == "high_order_graduation"
    assert "a pattern that repeats each turn with corners" in (found.decision.unlike or "")


def test_one_order_keeps_its_name() -> None:
    """A single wave above the orders of the model is named."""

    def error(disc: np.ndarray, temperature: np.ndarray, speed: float) -> np.ndarray:
        return paper_error(disc, temperature, speed) + 0.4 * np.cos(37.0 * disc)

    found = diagnosis_of(measurement_set(error, seed=2, reference=False))
    assert found.named is not None
    assert found.named.name == "high_order_graduation"


@pytest.mark.parametrize(
    ("orders", "is_one"),
    [
        ([21.0, 35.0, 49.0], True),
        ([24.0, 48.0, 72.0], True),
        ([21.0, 35.0], False),
        ([21.0, 34.0, 49.0], False),
        ([22.0, 34.0, 56.0], False),
    ],
)
def test_orders_of_one_pattern(orders: list[float], is_one: bool) -> None:
    """Three orders are one pattern if they have a common divisor of three or more."""
    assert (one_pattern(orders) is not None) == is_one


@pytest.mark.parametrize(("orders", "is_one"), [([30.0, 42.0], True), ([30.0, 34.0], False)])
def test_two_orders_and_a_local_defect(orders: list[float], is_one: bool) -> None:
    """Two orders are one pattern if their common divisor is five or more."""
    assert (one_pattern(orders, places=1) is not None) == is_one
    assert one_pattern(orders) is None


@pytest.mark.parametrize("size_arcsec", [1.0, pytest.param(5.0, marks=pytest.mark.large)])
def test_a_bracket_that_gives_way_to_the_root_of_speed(size_arcsec: float) -> None:
    """Runs at 30, −30, 90 and 30°/s: three equal offsets, and 1.73 times that in the fast run."""

    def bracket(time_s: np.ndarray, speed_rad_s: float) -> np.ndarray:
        share = np.sqrt(abs(speed_rad_s) / np.radians(30.0))
        return np.full(time_s.size, size_arcsec * share)

    found = diagnosis_of(measurement_set(head2_only=bracket, seed=4, reference=False))
    assert found.named is None
    assert found.verdict == "unknown"
    # The runs alone leave no candidate; a product of parts describes the offsets.
    assert found.decision.resembles is not None or found.description is not None


def _bent(size_arcsec: float, seed: int) -> MeasurementSet:
    """Return a set of a capture and a polygon, with a cubic part in the autocollimator's scale."""
    measured = measurement_set(seed=seed)
    assert measured.reference is not None
    error = measured.reference.error_arcsec
    share = error / np.max(np.abs(error))
    bent = error + size_arcsec * (share**3 - 0.6 * share)
    return replace(measured, reference=replace(measured.reference, error_arcsec=bent))


@pytest.mark.parametrize("size_arcsec", [pytest.param(0.5, marks=pytest.mark.large), -1.0])
def test_a_bent_scale_of_the_autocollimator_has_no_name(size_arcsec: float) -> None:
    """The cubic part looks like errors of faces, an axis motion or a gain, but is none of these."""
    found = diagnosis_of(_bent(size_arcsec, 5))
    assert found.effect_class == []
    assert found.verdict == "unknown"
