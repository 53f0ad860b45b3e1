"""Tests that effects are refused if their fitted values contradict the physics of the effect."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import binom

from arctrue.workbench.effects.base import CONTRADICTED_P, Parameter
from arctrue.workbench.effects.catalogue.polygon_face_error import _serial
from arctrue.workbench.effects.registry import built_in

EFFECTS = built_in()
FACES = 24
ARCSEC_A_COUNT = 0.08
SEPARATION_RAD = np.radians(33.0)


def _of_faces(values):  # type: ignore[no-untyped-def]
    effect = EFFECTS["polygon_face_error"]()
    covariance = np.eye(FACES) * 0.03**2
    heads = SimpleNamespace(head_separation_rad=SEPARATION_RAD)
    return effect.contradiction(values, covariance, {}, heads)


def _of_step(counts: float, sigma: float, count_arcsec: float | None = ARCSEC_A_COUNT):  # type: ignore[no-untyped-def]
    scale = 1.0 if count_arcsec is None else count_arcsec
    return EFFECTS["count_slip"]().contradiction(
        np.array([counts * scale]),
        np.array([[(sigma * scale) ** 2]]),
        {"run": 0.0, "instant": 1.0},
        SimpleNamespace(count_arcsec=count_arcsec),
    )


@pytest.mark.large
def test_faces_lapped_one_by_one_are_not_refused() -> None:
    """The rule wrongly refuses at most the share CONTRADICTED_P of 2,000 polygons with independent
    faces (99.9 % bound)."""
    random = np.random.default_rng(3)
    refused = sum(_of_faces(random.normal(0.0, 0.2, FACES)) is not None for _ in range(2000))
    assert refused <= binom.isf(0.001, 2000, CONTRADICTED_P)


@pytest.mark.parametrize("order", [2, 5, 11])
def test_a_wave_over_the_faces_is_no_polygon(order: int) -> None:
    random = np.random.default_rng(order)
    angle = np.arange(FACES) * 2.0 * np.pi / FACES
    reported = _of_faces(0.2 * np.cos(order * angle + 1.0) + random.normal(0.0, 0.03, FACES))
    assert reported is not None
    assert f"order {order}" in reported


def test_smooth_faces_without_one_largest_wave_are_no_polygon() -> None:
    """The rule refuses a polygon because neighbouring faces resemble each other, although no single
    order describes the faces: the error, as from a cross talk of the heads, has two neighbouring
    orders of equal size."""
    angle = np.arange(FACES) * 2.0 * np.pi / FACES
    values = np.cos(2 * angle + 1.0) + np.cos(3 * angle - 0.5)
    values += np.random.default_rng(2).normal(0.0, 0.6, FACES)
    reported = _of_faces(values)
    assert reported is not None
    assert "neighbouring faces" in reported


@pytest.mark.parametrize("faces", [FACES, 17])
@pytest.mark.parametrize("first", [1, 2])
def test_correlation_of_neighbours_has_its_distribution(faces: int, first: int) -> None:
    """Shares of 20,000 draws without the lower orders agree with p within four standard
    deviations."""
    angle = np.arange(faces) * 2.0 * np.pi / faces
    lower = [np.ones(faces), *(wave(angle) for wave in (np.cos, np.sin) if first == 2)]
    taken, _ = np.linalg.qr(np.stack(lower, axis=1))
    values = np.random.default_rng(8).normal(size=(20_000, faces))
    values -= (values @ taken) @ taken.T
    found = np.sum(values * np.roll(values, 1, axis=1), axis=1) / np.sum(values**2, axis=1)
    for quantile in (0.5, 0.9, 0.99):
        at = int(np.argsort(found)[int(quantile * found.size)])
        correlation, p_value = _serial(values[at], first)
        assert correlation == pytest.approx(found[at])
        spread = np.sqrt(quantile * (1.0 - quantile) / found.size)
        assert abs(p_value - (1.0 - quantile)) < 4.0 * spread


def test_faces_with_a_gain_stay_faces() -> None:
    """The gain of the autocollimator adds order 1 of the table's error to independent faces. A wave
    without independent faces, or with other waves, is no polygon."""
    angle = np.arange(FACES) * 2.0 * np.pi / FACES
    random = np.random.default_rng(3)
    wave, faces = 1.5 * np.cos(angle + 0.3), random.normal(0.0, 0.6, FACES)
    assert _of_faces(wave + faces) is None
    values = {
        f"face_{n}": Parameter(float(it), 0.03, "arcsec") for n, it in enumerate(wave + faces)
    }
    words = EFFECTS["polygon_face_error"]().describe_values(values)
    assert "autocollimator_gain or polygon_eccentricity" in words
    assert _of_faces(wave + 0.05 * faces) is not None
    assert _of_faces(wave + 0.8 * np.cos(4 * angle) + 0.2 * faces) is not None


def test_one_face_alone_may_be_a_place_of_the_table() -> None:
    values = np.random.default_rng(1).normal(0.0, 0.03, FACES)
    values[7] += 0.4
    reported = _of_faces(values)
    assert reported is not None
    assert "face 7" in reported


@pytest.mark.parametrize(("place_deg", "width_deg", "along"), [(26.7, 7.0, 0.8), (50.4, 9.0, 2.2)])
def test_a_flat_place_of_the_bearing_is_no_polygon(
    place_deg: float, width_deg: float, along: float
) -> None:
    """The axis dips at one place of the turn, and the rule must refuse a polygon as the cause. The
    columns come from plane geometry, order by order.

    Head 1 reads y, and R₂ − R₁ contains x·sin α + y·(cos α − 1). Up to order 20 the fitted
    graduation absorbs this second expression, divided by e^{jnα} − 1, so that the reference shows y
    minus the fitted graduation.
    """
    grid = np.arange(720) * np.pi / 360.0
    away = np.angle(np.exp(1j * (grid - np.radians(place_deg))))
    dip = np.fft.rfft(np.exp(-0.5 * (away / np.radians(width_deg)) ** 2))
    order = np.arange(1, 21)
    seen = np.cos(along) * np.sin(SEPARATION_RAD) + np.sin(along) * (np.cos(SEPARATION_RAD) - 1.0)
    shown = np.sin(along) * dip
    shown[order] -= seen * dip[order] / (np.exp(1j * order * SEPARATION_RAD) - 1.0)
    shown[0] = 0.0
    noise = np.random.default_rng(5).normal(0.0, 0.03, FACES)
    reported = _of_faces(0.7 * np.fft.irfft(shown, 720)[:: 720 // FACES] + noise)
    assert reported is not None
    assert "place of the table" in reported


@pytest.mark.parametrize("times", [2, 4, 6])
def test_faces_that_repeat_within_a_turn_are_a_shape_of_the_table(times: int) -> None:
    random = np.random.default_rng(times)
    part = random.normal(0.0, 0.2, FACES // times)
    reported = _of_faces(np.tile(part, times) + random.normal(0.0, 0.03, FACES))
    assert reported is not None
    if times == 2:
        # The twelve values are random and do not look like a wave; only their repetition within the
        # turn contradicts the effect.
        assert "repeat 2 times a turn" in reported


def test_few_faces_are_not_judged() -> None:
    effect = EFFECTS["polygon_face_error"]()
    assert effect.contradiction(np.array([1.0, -1.0, 1.0, -1.0]), np.eye(4), {}, None) is None  # type: ignore[arg-type]


def test_a_counter_loses_whole_counts() -> None:
    assert _of_step(12.1, 0.1) is None
    reported = _of_step(12.4, 0.1)
    assert reported is not None
    assert "12.40" in reported
    # An uncertainty of 0.3 counts is too large for a contradiction; without a known size of a
    # count, there is none either.
    assert _of_step(12.4, 0.3) is None
    assert _of_step(12.4, 0.1, count_arcsec=None) is None


def _of_line(frequency: float, visits: int = 10, mixed: bool = False, pauses_s: float = 0.0):  # type: ignore[no-untyped-def]
    """Return the contradiction of a line in time, for 24 stations up and down, 4 s each, so that
    each station is visited again after 192 s. Each interval between visits differs from this by up
    to half of ``pauses_s``."""
    up = np.arange(FACES) * 2.0 * np.pi / FACES
    target = np.tile(np.concatenate([up, up[::-1]]), visits)
    if mixed:
        target = np.random.default_rng(4).permutation(target)
    pauses = np.random.default_rng(5).uniform(-0.5, 0.5, visits) * pauses_s
    rows = SimpleNamespace(
        time_s=np.arange(target.size) * 4.0 + np.repeat(np.cumsum(pauses), 2 * FACES),
        target_rad=target,
        direction=np.tile(np.repeat([1.0, -1.0], FACES), visits),
    )
    return EFFECTS["periodic_error"]().contradiction(
        np.array([1.0, 0.0]), np.eye(2) * 0.01,
        {"order": 0.0, "frequency": frequency, "in_time": 1.0, "in_capture": 0.0},
        SimpleNamespace(reference=rows, capture=None),  # type: ignore[arg-type]
    )  # fmt: skip


def test_a_line_that_keeps_to_the_schedule_of_the_visits_is_none_in_time() -> None:
    """The rule refuses a line in time that has the period of the visits. In an earlier version, a
    bracket that leans with the direction was named a periodic error of 192 s."""
    reported = _of_line(1.0 / 192.0)
    assert reported is not None
    assert "192 s" in reported
    assert _of_line(3.0 / 192.0 + 0.1 / 1920.0) is not None
    # A load that changes in every other pass looks like a line of half this frequency: its phase
    # is then half a period later at every visit.
    reported = _of_line(2.5 / 192.0)
    assert reported is not None
    assert "alternates from pass to pass" in reported
    assert _of_line(2.5 / 192.0 + 0.5 / 1920.0) is None
    # The rule accepts a line that is half a resolution of ten visits away from this frequency,
    # because the line drifts against the visits. It also accepts a much slower line.
    assert _of_line(1.0 / 192.0 + 0.5 / 1920.0) is None
    assert _of_line(0.1 / 1920.0) is None
    # If the visits are in mixed order, or each station is visited once, the visits have no
    # frequency.
    assert _of_line(1.0 / 192.0, mixed=True) is None
    assert _of_line(1.0 / 192.0, visits=1) is None


def test_a_line_that_keeps_its_phase_at_irregular_visits_is_none_in_time() -> None:
    """The rule refuses a line at the mean frequency of visits whose times differ by some
    percent. In an earlier version, a friction loop was named a periodic error of the cycle from
    station to station and back."""
    refused = _of_line(1.0 / 192.0, visits=5, pauses_s=24.0)
    assert refused is not None
    assert "every visit" in refused
    assert _of_line(1.37 / 192.0, visits=5, pauses_s=24.0) is None
    assert _of_line(1.0 / 192.0, visits=5, pauses_s=400.0) is None


def _of_order(order: float, sigma: float):  # type: ignore[no-untyped-def]
    found = {
        "order": Parameter(order, sigma, "1"),
        "head1_amplitude": Parameter(0.5, 0.01, "arcsec"),
    }
    return EFFECTS["bearing_ball_pass"]().search_contradiction(found, SimpleNamespace())  # type: ignore[arg-type]


def test_an_order_that_cannot_be_reported_from_a_half_one_is_no_ball_pass() -> None:
    """The rule refuses a ball pass at a half-integer order. In an earlier version, a belt that
    repeats every two turns was named a ball pass of order 0.499 ± 0.008."""
    reported = _of_order(0.4992, 0.0076)
    assert reported is not None
    assert "every two turns" in reported
    whole = _of_order(3.01, 0.004)
    assert whole is not None
    assert "every turn" in whole
    # If the uncertainty is much smaller, the order differs from a half-integer order. If the
    # uncertainty is unknown, there is no contradiction.
    assert _of_order(0.4992, 0.00012) is None
    assert _of_order(7.85, 0.003) is None
    assert _of_order(0.4992, float("nan")) is None


def test_an_effect_without_such_a_rule_is_never_refused() -> None:
    effect = EFFECTS["hysteresis"]()
    assert effect.contradiction(np.array([1.0]), np.eye(1), {}, None) is None  # type: ignore[arg-type]
