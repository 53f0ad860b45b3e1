"""Tests that causes outside the catalogue get no name although they look like an effect; the tests
compute these causes from physics."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.studies.benchmark.diagnosis import diagnosed
from arctrue.workbench.diagnose.detections import RegularCause
from arctrue.workbench.diagnose.own_tests import one_pattern, shape_with_corners
from arctrue.workbench.effects.catalogue.periodic_error import PeriodicError
from arctrue.workbench.inference.forward.search import Line
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.small_sets import measurement_set, paper_error


@pytest.mark.large
@pytest.mark.parametrize("pairs", [6, 7])
def test_a_disc_written_in_sectors_is_no_single_order(pairs: int) -> None:
    """The diagnosis names no single order for a disc written in sectors, whose error alternates
    between +0.4″ and −0.4″. This square wave also contains 3, 5 and 7 times its order."""

    def error(disc: np.ndarray, temperature: np.ndarray, speed: float) -> np.ndarray:
        return paper_error(disc, temperature, speed) + 0.4 * np.sign(np.sin(pairs * disc + 0.3))

    found = diagnosis_of(measurement_set(error, seed=2, reference=False))
    assert found.verdict == "unknown"
    assert found.decision.resembles is not None
    assert found.decision.resembles.name == "high_order_graduation"
    assert "a pattern with corners that repeats each turn" in (found.decision.unlike or "")


@pytest.mark.large
def test_one_order_keeps_its_name() -> None:
    """The diagnosis names a single wave of an order above the orders of the model."""

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
    """Three orders form one pattern if they have a common divisor of three or more."""
    assert (one_pattern(orders) is not None) == is_one


@pytest.mark.parametrize(("orders", "is_one"), [([30.0, 42.0], True), ([30.0, 34.0], False)])
def test_two_orders_and_a_local_defect(orders: list[float], is_one: bool) -> None:
    """Two orders and a local defect form one pattern if the common divisor of the orders is five or
    more."""
    assert (one_pattern(orders, places=1) is not None) == is_one
    assert one_pattern(orders) is None


@pytest.mark.large
@pytest.mark.parametrize("size_arcsec", [1.0, 5.0])
def test_a_bracket_that_gives_way_to_the_root_of_speed(size_arcsec: float) -> None:
    """The diagnosis gives no name to a bracket that moves with the root of the speed. Runs at 30,
    −30, 90 and 30°/s have three equal offsets, and an offset 1.73 times as large in the fast
    run."""

    def bracket(time_s: np.ndarray, speed_rad_s: float) -> np.ndarray:
        share = np.sqrt(abs(speed_rad_s) / np.radians(30.0))
        return np.full(time_s.size, size_arcsec * share)

    found = diagnosis_of(measurement_set(head2_only=bracket, seed=4, reference=False))
    assert found.named is None
    assert found.verdict == "unknown"
    # Either an effect that resembles the offsets remains, or a product of parts describes them.
    assert found.decision.resembles is not None or found.description is not None


def _bent(size_arcsec: float, seed: int) -> MeasurementSet:
    """Return a set with a capture and a polygon; the scale of the autocollimator has a cubic
    part."""
    measured = measurement_set(seed=seed)
    assert measured.reference is not None
    error = measured.reference.error_arcsec
    share = error / np.max(np.abs(error))
    bent = error + size_arcsec * (share**3 - 0.6 * share)
    return replace(measured, reference=replace(measured.reference, error_arcsec=bent))


@pytest.mark.large
@pytest.mark.parametrize("size_arcsec", [0.5, -1.0])
def test_a_bent_scale_of_the_autocollimator_has_no_name(size_arcsec: float) -> None:
    """The cubic part looks like face errors, an axis motion or a gain; the diagnosis must name none
    of these."""
    found = diagnosis_of(_bent(size_arcsec, 5))
    assert found.effect_class == []
    assert found.verdict == "unknown"


def _log_that_divides_the_turn(extra: np.ndarray, turn: np.ndarray, noise: float) -> MeasurementSet:
    """Return a log at 12°/s and 30 Hz over two turns up and two down, whose samples fall on 900
    angles per turn."""
    random = np.random.default_rng(4)
    angle = 2.0 * np.pi * turn
    error = 20.0 * np.cos(angle + 0.4) + 3.0 * np.cos(2.0 * angle) + 0.5 * np.cos(7.0 * angle)
    error += extra + random.normal(0.0, noise, angle.size)
    up = np.diff(turn, prepend=turn[0] - 1.0) > 0.0
    up[-1] = up[-2]
    reference = Reference(
        360.0 * turn,
        error,
        run=np.where(up, 0, 1),
        time_s=np.arange(turn.size) / 30.0,
        direction=np.where(up, 1, -1),
    )
    return MeasurementSet(Table(), None, reference, title="log")


UP_AND_DOWN = np.concatenate([np.arange(1800), np.arange(1799, -1, -1)]) / 900.0


@pytest.mark.large
def test_a_log_that_divides_the_turn_is_searched_for_lines() -> None:
    """The diagnosis searches a log for periodic errors although its samples fall on the same angles
    in each turn, as the readings of stations do."""
    line = 3.0 * np.cos(31.4 * 2.0 * np.pi * UP_AND_DOWN)
    _, found = diagnosed(_log_that_divides_the_turn(line, UP_AND_DOWN, 1.0))
    assert [round(cause.lines[0].rate, 1) for cause in found.detections.causes] == [31.4]
    assert found.named is not None
    assert found.named.name == "periodic_error"


@pytest.mark.large
def test_a_square_wave_over_the_turn_is_no_line() -> None:
    """The diagnosis names no periodic error for a square wave that jumps at six angles of the turn.
    The model contains its orders 3, 9 and 15; the orders 21, 27, … remain."""
    wave = 12.0 * np.sign(np.sin(3.0 * 2.0 * np.pi * UP_AND_DOWN + 0.5))
    _, found = diagnosed(_log_that_divides_the_turn(wave, UP_AND_DOWN, 1.0))
    assert found.verdict == "unknown"
    assert "corners" in (found.decision.unlike or "")


def _causes(lines: dict[float, float], turns: float = 4.0) -> list[RegularCause]:
    """Return regular causes with these orders and amplitudes."""
    return [
        RegularCause(
            PeriodicError(),
            {},
            (Line(order, size, 0.0, size, 0.9, 50.0, 50.0, turns * order, 100.0),),
            False,
            None,
        )
        for order, size in lines.items()
    ]


@pytest.mark.parametrize(
    ("lines", "is_one"),
    [
        ({order: 1.0 / order for order in (21.0, 27.0, 33.0, 39.0, 45.0)}, True),
        ({order: 1.0 / order**2 for order in (21.0, 23.02, 24.99, 29.0, 31.0)}, True),
        # Ten of the 17 odd orders from 21 to 53, with sizes at the limit of the search.
        ({float(n): n**-0.5 for n in (21, 23, 25, 27, 29, 31, 33, 39, 41, 53)}, True),
        ({float(n): n**-0.5 for n in (21, 23, 26, 27, 29, 31, 33, 39, 41, 53)}, False),
        # The orders of stator slots and their multiples: the base order is a line itself.
        ({72.0: 400.0, 144.0: 90.0, 216.0: 40.0, 288.0: 20.0}, False),
        # The orders of a motor's poles, teeth and slots: multiples of 4 that are far apart.
        ({100.0: 340.0, 56.0: 61.0, 300.0: 35.0, 48.0: 29.0}, False),
        ({21.0: 1.0, 27.0: 0.3, 33.0: 1.1, 39.0: 0.2}, False),
        ({21.4: 1.0, 27.0: 0.8, 33.0: 0.6, 39.0: 0.5}, False),
        ({21.0: 1.0, 27.0: 0.8, 33.0: 0.6}, False),
    ],
)
def test_lines_of_one_shape(lines: dict[float, float], is_one: bool) -> None:
    """Four or more orders on a grid of equal distances, whose sizes fall steadily, form one shape
    with corners, unless the base order itself is one of them."""
    assert (shape_with_corners(_causes(lines)) is not None) == is_one


@pytest.mark.parametrize(
    ("by_direction_arcsec", "is_named"),
    [pytest.param(0.5, True, marks=pytest.mark.large), (15.0, False)],
)
def test_runs_that_differ_little_leave_a_constant_its_name(
    by_direction_arcsec: float, is_named: bool
) -> None:
    """If the displacement of head 2 is 20″ ± 0.5″, depending on the direction, it counts as
    constant.

    With 20″ ± 15″ it has no name, because the effect itself may depend on the direction.
    """
    made = measurement_set(
        head2_only=lambda time, speed: np.full(
            time.size, 20.0 + by_direction_arcsec * np.sign(speed)
        )
    )
    found = diagnosis_of(made)
    assert (found.named is not None and found.named.name == "head_angle_error") == is_named
