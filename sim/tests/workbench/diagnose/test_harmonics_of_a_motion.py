"""Tests that the harmonics of a cam, which two heads and a reference show, are no single orders of
the axis.

The axis moves by (x, y): head 1 reads y, and head 2 reads x·sin α + y·cos α, both divided by the
radius (docs/architecture.md, "Head geometry").
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import sawtooth

from arctrue.measurement import MeasurementSet
from arctrue.workbench.diagnose.own_tests import further_motion
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.small_sets import ALPHA, COUNTS_PER_REV, Float, measurement_set

MATTERS_ARCSEC = 0.04
"""Half a count of 2²⁴ a turn."""
COUNTS_PER_ARCSEC = COUNTS_PER_REV / 1_296_000.0
DIRECTION_RAD = 2.3
Motion = Callable[[Float], tuple[Float, Float]]


def _cam(order: int, size_arcsec: float) -> Motion:
    """Return a motion along a line that rises over 0.88 of a period and returns in the other
    0.12."""

    def motion(angle: Float) -> tuple[Float, Float]:
        wave = size_arcsec * sawtooth(order * angle + 0.9, 0.88)
        return wave * np.cos(DIRECTION_RAD), wave * np.sin(DIRECTION_RAD)

    return motion


def _ellipse(order: int, size_arcsec: float) -> Motion:
    def motion(angle: Float) -> tuple[Float, Float]:
        return (
            size_arcsec * np.cos(order * angle + 0.3),
            0.6 * size_arcsec * np.cos(order * angle + 1.9),
        )

    return motion


def _set(motion: Motion, seed: int, faces_arcsec: float = 0.0) -> MeasurementSet:
    """Return a set of a table whose axis moves; ``faces_arcsec``: standard deviation of the face
    errors of the polygon."""
    made = measurement_set(seed=seed, turns=1)
    rows, there = made.capture, made.reference
    assert rows is not None
    assert there is not None
    assert there.head1_counts is not None
    x, y = motion(2.0 * np.pi * rows.head1_counts / COUNTS_PER_REV)
    capture = replace(
        rows,
        head1_counts=rows.head1_counts + _counts(y),
        head2_counts=rows.head2_counts + _counts(x * np.sin(ALPHA) + y * np.cos(ALPHA)),
    )
    _, at_stations = motion(np.radians(there.target_deg))
    faces = faces_arcsec * np.random.default_rng(seed).normal(size=24)
    face = np.round(there.target_deg / 15.0).astype(np.int64) % 24
    reference = replace(
        there,
        error_arcsec=there.error_arcsec + at_stations + faces[face],
        head1_counts=there.head1_counts + _counts(at_stations),
    )
    return replace(made, capture=capture, reference=reference)


def _counts(values_arcsec: Float) -> np.ndarray:
    return np.round(values_arcsec * COUNTS_PER_ARCSEC).astype(np.int64)


def _further(made: MeasurementSet, *orders: int) -> str | None:
    effects = built_in()
    motion = effects["radial_error_motion"](orders=list(orders))
    model = [Term(effects["graduation_harmonics"](), {}), Term(motion, {})]
    found = fit(model, observations_of(made))
    best = SimpleNamespace(effect=motion, parameters=lambda: found.parameters()[-1])
    return further_motion(best, Residuals(found), MATTERS_ARCSEC)  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_cam_of_order_5_has_order_10(seed: int) -> None:
    """Order 10 of a cam of 0.6″ is 0.2″; the mean of twelve readings of a station has 0.04″."""
    found = _further(_set(_cam(5, 0.6), seed), 5)
    assert found is not None
    assert "the axis also moves at order 10" in found


def test_a_cam_of_order_3_has_order_9() -> None:
    found = _further(_set(_cam(3, 0.8), 4), 3, 6)
    assert found is not None
    assert "the axis also moves at order 9" in found


@pytest.mark.parametrize(("order", "size_arcsec"), [(5, 0.5), (4, 3.0), (4, 0.4), (8, 0.4)])
def test_another_order_up_to_8_belongs_to_the_effect(order: int, size_arcsec: float) -> None:
    def motion(angle: Float) -> tuple[Float, Float]:
        x, y = (np.add(*pair) for pair in zip(first(angle), second(angle), strict=True))
        return x, y

    first, second = _ellipse(2, 1.0), _ellipse(order, size_arcsec)
    assert _further(_set(motion, 7), 2, order) is None


@pytest.mark.parametrize("order", [2, 3, 5])
def test_one_order_is_the_whole_motion(order: int) -> None:
    assert _further(_set(_ellipse(order, 2.0), order), order) is None


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_face_errors_are_no_harmonics(seed: int) -> None:
    """Face errors of 0.3″ change all orders, also order 10."""
    assert _further(_set(_ellipse(5, 1.0), seed, faces_arcsec=0.3), 5) is None


@pytest.mark.large
@pytest.mark.parametrize(("motion", "is_named"), [(_cam(5, 0.6), False), (_ellipse(5, 0.6), True)])
def test_the_diagnosis_names_one_order_and_no_cam(motion: Motion, is_named: bool) -> None:
    found = diagnosis_of(_set(motion, 6))
    assert found.verdict == ("named" if is_named else "unknown")
    first = found.named or found.decision.resembles
    assert first is not None
    assert first.name == "radial_error_motion"
