"""Tests that sets of four heads show causes that two heads without a reference cannot show; only
numpy simulates the sets."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from arctrue.workbench.diagnose.diagnosis import Diagnosis
from arctrue.workbench.effects.base import Parameter
from arctrue.workbench.effects.registry import built_in
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.heads.four_heads import (
    COUNTS,
    DISC,
    PLACES_DEG,
    RADIUS_M,
    Float,
    FourHeads,
    ball_pass,
    orders_2_and_3,
)

ARCSEC_A_METRE = 648_000.0 / np.pi / RADIUS_M
SIGMAS = 5.0
"""Largest accepted deviation in stated standard uncertainties; a value exceeds it with p < 10⁻⁶."""


def _named(world: FourHeads, effect: str) -> tuple[Diagnosis, dict[str, Parameter]]:
    found = diagnosis_of(world.measured(7))
    assert found.decision.verdict == "named", found.decision
    assert found.decision.first is not None
    assert found.decision.first.name == effect
    return found, found.decision.first.parameters()


def _close(found: Parameter, expected: float) -> None:
    assert abs(found.value - expected) < SIGMAS * found.sigma
    assert found.sigma < 0.1 * max(abs(expected), 0.1)


def test_nothing_is_adequate() -> None:
    found = diagnosis_of(FourHeads().measured(7))
    assert found.decision.verdict == "adequate"
    assert found.decision.first is None


@pytest.mark.large
def test_a_ball_pass_is_named_with_what_head_1_sees() -> None:
    """The diagnosis names a ball-pass motion of the axis by 0.25 µm without a reference."""
    _, values = _named(FourHeads(motion=ball_pass(0.25e-6, 4.37)), "bearing_ball_pass")
    _close(values["head1_amplitude"], 0.25e-6 * ARCSEC_A_METRE)
    assert abs(values["order"].value - 4.37) < 1e-3


@pytest.mark.parametrize("head", [3, 4])
def test_a_wrong_place_of_a_head_does_not_hide_a_motion_of_the_axis(head: int) -> None:
    """The place of a head is stated wrong by 4″; a line of any cause has order 3 in every head."""
    made = FourHeads(motion=lambda angle: 0.35e-6 * np.exp(-3j * angle + 0.2j)).measured(7)
    places = list(PLACES_DEG)
    places[head - 1] += 4.0 / 3600.0
    found = diagnosis_of(replace(made, table=replace(made.table, head_places_deg=tuple(places))))
    assert found.named is not None
    assert found.named.name == "radial_error_motion"
    assert [item.name for item in found.further] == ["head_angle_error"]


@pytest.mark.parametrize("heads", [pytest.param(3, marks=pytest.mark.large), 4])
def test_synchronous_motion_is_named_without_a_reference(heads: int) -> None:
    world = FourHeads(motion=orders_2_and_3(0.1e-6, 0.05e-6), places_deg=PLACES_DEG[:heads])
    _, values = _named(world, "radial_error_motion")
    assert {name[-1] for name in values} == {"2", "3"}
    if heads < 4:
        # Three heads show that the axis moves, but cannot separate all parts of this motion from
        # the disc.
        return
    second, third = 0.1e-6 * ARCSEC_A_METRE, 0.05e-6 * ARCSEC_A_METRE
    expected = {
        "x_cos_2": second * np.cos(0.7), "x_sin_2": -second * np.sin(0.7),
        "y_cos_2": 0.0, "y_sin_2": 0.0,
        "x_cos_3": third * np.cos(0.2), "x_sin_3": third * np.sin(0.2),
        "y_cos_3": third * np.sin(0.2), "y_sin_3": -third * np.cos(0.2),
    }  # fmt: skip
    for name, value in expected.items():
        _close(values[name], value)


@pytest.mark.large
@pytest.mark.parametrize(("order", "direction_rad"), [(4, 3.3), (3, 0.9)])
def test_a_saw_tooth_of_the_axis_is_more_than_its_low_orders(
    order: int, direction_rad: float
) -> None:
    """A cam moves the axis by ±0.15 µm in a saw tooth. The orders of radial_error_motion end at 8,
    so that a tenth of the mean square of the error remains at higher multiples."""

    def motion(angle: Float) -> Float:
        share = np.mod(order * angle / (2.0 * np.pi) + 0.2, 1.0)
        wave = np.interp(share, [0.0, 0.9, 1.0], [-1.0, 1.0, -1.0])
        return np.asarray(0.15e-6 * wave * np.exp(1j * direction_rad))

    found = diagnosis_of(FourHeads(motion=motion).measured(7))
    assert found.verdict == "unknown"
    assert found.decision.resembles is not None
    assert found.decision.resembles.name == "radial_error_motion"
    multiples = f"{order}, {2 * order}, "
    assert f"a translation of the axis that repeats at orders {multiples}" in str(
        found.decision.unlike
    )


@pytest.mark.large
def test_a_backward_circle_of_order_1_is_no_eccentric_disc() -> None:
    """The diagnosis names a backward circle of order 1; a forward circle would look like an
    eccentric disc."""
    backward = FourHeads(motion=lambda angle: 0.1e-6 * np.exp(-1j * angle))
    _, values = _named(backward, "radial_error_motion")
    assert {name[-1] for name in values} == {"1"}
    forward = FourHeads(motion=lambda angle: 0.1e-6 * np.exp(1j * angle))
    assert diagnosis_of(forward.measured(7)).decision.verdict == "adequate"


@pytest.mark.large
@pytest.mark.parametrize("head", [1, 3])
def test_a_bracket_that_creeps_is_named_with_its_head(head: int) -> None:
    creep = tuple(0.5 if number == head else 0.0 for number in range(1, 5))
    _, values = _named(FourHeads(creep_arcsec_k=creep), "thermal_head_drift")
    assert list(values) == [f"drift_head{head}"]
    _close(values[f"drift_head{head}"], 0.5)


def test_two_heads_with_a_cause_each_are_both_named() -> None:
    """The bracket of head 1 creeps, and head 2 is read late; both change the offsets of the runs,
    so that each adds to the gain of the other's effect at every head. A constant may follow: the
    temperature of the stated places is not known."""
    world = FourHeads(creep_arcsec_k=(0.68, 0.0, 0.0, 0.0), later_s=(0.0, 19e-6, 0.0, 0.0))
    found = diagnosis_of(world.measured(7))
    assert found.named is not None
    causes = {item.name: item.parameters() for item in (found.named, *found.further)}
    assert list(causes)[:2] == ["thermal_head_drift", "timing_skew"]
    _close(causes["thermal_head_drift"]["drift_head1"], 0.68)
    _close(causes["timing_skew"]["skew"], 19.0)


@pytest.mark.large
@pytest.mark.parametrize("head", [1, 2, 3, 4])
@pytest.mark.parametrize("name", ["head_angle_error", "thermal_head_drift", "timing_skew"])
def test_an_effect_of_one_head_speaks_of_that_head(name: str, head: int) -> None:
    """The words of an effect of one of several heads name this head, not head 2, α = 33° or
    R₂ − R₁."""
    effect = built_in()[name](heads=[head])
    assert re.findall(r"[Hh]ead (\d)", effect.physics) == [str(head)]
    assert not re.search("R₂|33°", effect.physics)
    said = re.findall(r"head (\d)", effect.compensation_note)
    assert set(said) <= {"1", str(head)}
    assert ("the output is the reading of head 1" in effect.compensation_note) == (
        head == 1 and name != "head_angle_error"
    )


@pytest.mark.parametrize("head", [2, 4])
def test_a_bracket_that_vibrates_is_no_damped_oscillation(head: int) -> None:
    """A sine of 0.4″ and 23.1 Hz of one head, with a phase of its own in each run."""
    made = FourHeads(samples=2000).measured(11)
    rows = made.capture
    assert rows is not None
    phase = np.random.default_rng(11).uniform(0.0, 2.0 * np.pi, 4)[rows.run]
    sine = 0.4 * np.sin(2.0 * np.pi * 23.1 * rows.time_s + phase)
    name = f"head{head}_counts"
    counts = getattr(rows, name) + np.rint(sine / 1_296_000.0 * COUNTS).astype(np.int64)
    found = diagnosis_of(replace(made, capture=replace(rows, **{name: counts})))
    assert found.named is not None
    assert found.named.name == "vibration"
    assert found.named.parameters()["frequency"].value == pytest.approx(23.1, abs=0.01)


def test_heads_that_are_read_one_after_the_other_are_named_together() -> None:
    """A delay of one head alone does not explain the offsets of the runs. With such a delay in the
    model, the estimated scatter of the index would hide the delays of the other heads."""
    later = (0.0, 1e-6, -1.5e-6, 2.5e-6)
    _, values = _named(FourHeads(later_s=later), "timing_skew")
    assert list(values) == ["skew", "skew_head3", "skew_head4"]
    for found, expected in zip(values.values(), later[1:], strict=True):
        assert abs(found.value - 1e6 * expected) < SIGMAS * found.sigma


@pytest.mark.large
@pytest.mark.parametrize("head", [1, 3])
def test_lost_counts_are_named_with_their_head(head: int) -> None:
    _, values = _named(FourHeads(slip=(1, head, 40)), "count_slip")
    assert (values["run"].value, values["head"].value) == (1.0, float(head))
    # A step of head 1 appears in every Rᵢ − R₁ with a negative sign.
    expected = -40.0 if head == 1 else 40.0
    _close(values["counts"], expected)


@pytest.mark.large
@pytest.mark.parametrize("head", [1, 4])
def test_what_has_no_name_is_described_with_its_head(head: int) -> None:
    found = diagnosis_of(FourHeads(settling=(head, 1.5, 8.0)).measured(7))
    assert found.decision.verdict == "unknown"
    assert found.decision.described is not None
    assert f"head {head} only" in found.decision.described.effect.describe({})
    assert found.decision.described.effect.parts[0].startswith("settling")


@pytest.mark.large
def test_an_order_that_two_heads_do_not_see_is_named() -> None:
    """The diagnosis names order 120, which two heads do not see: 120 · 33° are eleven turns, so
    that R₂ − R₁ does not show the order, but the other differences do."""
    disc = (*DISC, (120, 0.3, 0.5))
    found, values = _named(FourHeads(disc=disc), "high_order_graduation")
    assert values["order"].value == 120.0
    _close(values["amplitude"], 0.3)
    assert 120 not in found.covers.blind_orders
    two = diagnosis_of(FourHeads(disc=disc, places_deg=PLACES_DEG[:2]).measured(7))
    assert two.decision.verdict == "adequate"
    assert 120 in two.covers.blind_orders


@pytest.mark.large
@pytest.mark.parametrize(
    ("order", "size_arcsec"),
    [
        (97, 0.6),
        (120, 2.0),
        (120, 0.6),
        (200, 2.0),
    ],
)
def test_an_order_of_an_eccentric_disc_is_an_order_of_the_disc(
    order: int, size_arcsec: float
) -> None:
    """The diagnosis names an order of an eccentric disc: the 80″ of order 1 shift the phase of
    order 200 by 0.08 rad, differently at each head.

    A periodic error with its own amplitude and phase at each head also describes these differences,
    and therefore has a larger gain.
    """
    found, values = _named(
        FourHeads(disc=(*DISC, (order, size_arcsec, 0.5)), samples=1200), "high_order_graduation"
    )
    assert values["order"].value == order
    _close(values["amplitude"], size_arcsec)
    line = next(item for item in found.candidates if item.name == "periodic_error")
    assert line.gain > found.decision.first.gain  # type: ignore[union-attr]


@pytest.mark.large
@pytest.mark.parametrize("order", [97.0, 97.02])
def test_a_line_of_the_axis_is_no_order_of_the_disc(order: float) -> None:
    """The diagnosis names no order of the disc for an axis that oscillates by 0.2 µm along x: each
    head shows a different share of this motion, and the disc does not have this order."""
    world = FourHeads(motion=lambda angle: 0.2e-6 * np.cos(order * angle) + 0j)
    _, values = _named(world, "periodic_error")
    assert values["order"].value == pytest.approx(order, abs=SIGMAS * values["order"].sigma)


@pytest.mark.large
def test_a_line_with_a_whole_order_is_not_the_whole_order() -> None:
    """The diagnosis names no integer order for a sine whose order differs by 0.02 from an integer:
    over the two turns of each run, the phase of the sine advances by 14°."""
    _, values = _named(FourHeads(disc=(*DISC, (97.02, 0.6, 0.5))), "periodic_error")
    assert values["order"].value == pytest.approx(97.02, abs=SIGMAS * values["order"].sigma)


def test_two_heads_of_the_same_world_do_not_name_the_motion() -> None:
    """The diagnosis of two heads does not name the synchronous motion, which looks like an error of
    the disc; only further heads can separate the two."""
    world = FourHeads(motion=orders_2_and_3(0.1e-6, 0.05e-6), places_deg=PLACES_DEG[:2])
    decision = diagnosis_of(world.measured(7)).decision
    assert decision.first is None or decision.first.name != "radial_error_motion"
