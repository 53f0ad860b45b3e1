"""Tests of the C calibration against the numpy reference."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from sim.tests.calibration.synthetic import ARCSEC, COUNTS, Disc, capture_of, turn_angles
from sim.tests.firmware.calibrator import (
    ALPHA_RAD,
    CaptureInC,
    capture_in_c,
    estimate,
    per_order,
    values_of,
)
from sim.tests.firmware.library import firmware

from arctrue.calibration import Estimate, fourier, least_squares, whole_turns
from arctrue.calibration.harmonics import as_function_of_reading

EQUAL_TO = 1e-9
"""Largest difference from the reference, relative to the largest |E_n| (a requirement of the
project)."""
GRAM_APPROXIMATION = 1e-3
"""Relative error of the covariance, whose normal matrix is a second-order approximation.

The difference of the heads varies by δ = 85″, and N = 32 is the highest order: the error is
(2N·δ)³/6, divided by the square of the weakest column, |e^{jnα} − 1|² = 0.0027.
"""
REFERENCE_ROUNDING = 1e-5
"""Relative rounding error of the reference's residual |y|² − 2xᵀXᵀy + xᵀXᵀXx.

If the separation that the index marks give differs from the nominal one by 3000″, terms of 1e11
arcsec² cancel to 2e2 arcsec² (12,000 samples with a noise of 0.14″). This magnifies their rounding
errors by 5e8.
"""

DISC = Disc({1: (150.0, 0.4), 2: (6.0, 4.2), 3: (1.2, 2.9), 11: (0.4, 1.0), 31: (0.3, 5.0)})
METHODS = {"fourier": fourier, "least_squares": least_squares}
CASES: dict[str, dict[str, Any]] = {
    "forward": {},
    "backward": {"direction": -1, "start": 2.0},
    "ripple": {"ripple_rad": 0.002},
    "few samples": {"samples": 517},
    "before zero": {"start": -1.7},
}


def counts_of(disc: Disc = DISC, noise: float = 0.1, seed: int = 3, **angles: Any) -> Any:
    """Return counts (2, n) of one turn, with the sample that closes the turn."""
    samples = angles.pop("samples", 12_000)
    theta = turn_angles(samples, 2, **angles)[: samples + 1]
    return disc.heads(theta, noise, np.random.default_rng(seed))


def reference(
    method: str,
    counts: Any,
    orders: int = 32,
    separation: Any = None,
    counts_per_rev: int = COUNTS,
    alpha_rad: float = ALPHA_RAD,
) -> Estimate:
    turns = whole_turns(capture_of([counts]), counts_per_rev, None, orders)
    made, _ = METHODS[method](
        turns, counts_per_rev, alpha_rad, np.arange(1, orders + 1), separation
    )
    return made


def u_index_rad(counts_per_rev: int, detection_arcsec: float = 0.0) -> float:
    """Return the standard uncertainty of R₂ − R₁ that the detection of the index causes.

    The uncertainty contains a rectangular distribution of ±1 count for each head, and the
    difference of the places at which the heads detect the mark.
    """
    head = 2.0 * np.pi / counts_per_rev / np.sqrt(3.0)
    return float(np.sqrt(2.0 * head**2 + (detection_arcsec * ARCSEC) ** 2))


def assert_equal(made: Any, expected: Estimate) -> None:
    largest = expected.amplitude_arcsec.max() / 2.0
    assert np.abs(values_of(made) - expected.values).max() < EQUAL_TO * largest
    assert abs(made.measured_separation_rad - expected.measured_separation_rad) < 1e-12
    assert abs(made.separation_rad - expected.head_separation_rad) < 1e-12
    assert made.residual_rms_arcsec == pytest.approx(
        expected.residual_rms_arcsec, rel=REFERENCE_ROUNDING
    )
    assert made.iterations == expected.iterations
    seen = np.isfinite(expected.noise_gain)
    np.testing.assert_array_equal(per_order(made, "seen"), seen)
    # A change of α by 1e-12 rad changes a gain of 1,000 at order n by n·1e-9 of its value.
    np.testing.assert_allclose(per_order(made, "noise_gain"), expected.noise_gain, rtol=1e-6)
    ffi, library = firmware()
    u = [library.harmonic_uncertainty(ffi.addressof(made.harmonic[p])) for p in range(made.orders)]
    np.testing.assert_allclose(u, expected.u_component_arcsec, rtol=GRAM_APPROXIMATION)
    assert made.u_measured_separation_rad == pytest.approx(
        expected.u_measured_separation_rad, rel=1e-6
    )


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("method", METHODS)
def test_equal_to_the_reference(method: str, case: str) -> None:
    counts = counts_of(**CASES[case])
    reason, made = estimate(method, capture_in_c(counts))
    assert reason == "none"
    assert_equal(made, reference(method, counts))


@pytest.mark.parametrize("choice", ["measured", "nominal"])
@pytest.mark.parametrize("method", METHODS)
def test_separation_from_the_capture_or_the_drawing(method: str, choice: Any) -> None:
    counts = counts_of(Disc(DISC.orders, alpha_deg=33.01))
    _, library = firmware()
    asked = {"measured": library.SEPARATION_MEASURED, "nominal": library.SEPARATION_NOMINAL}
    reason, made = estimate(method, capture_in_c(counts), separation=asked[choice])
    assert reason == "none"
    assert_equal(made, reference(method, counts, separation=choice))


@pytest.mark.parametrize("method", METHODS)
def test_an_index_that_was_not_found_is_not_believed(method: str) -> None:
    counts = counts_of()
    counts[1] += 40_000  # 0.86°
    reason, made = estimate(method, capture_in_c(counts))
    assert reason == "none"
    assert made.separation_choice == firmware()[1].SEPARATION_NOMINAL
    assert_equal(made, reference(method, counts))


@pytest.mark.parametrize("method", METHODS)
def test_whole_turns_between_the_counters_mean_nothing(method: str) -> None:
    counts = counts_of()
    _, plain = estimate(method, capture_in_c(counts))
    counts[1] -= 3 * COUNTS
    _, moved = estimate(method, capture_in_c(counts))
    np.testing.assert_array_equal(values_of(plain), values_of(moved))


@pytest.mark.parametrize("method", METHODS)
def test_an_order_that_cannot_be_seen(method: str) -> None:
    """The fit marks order 10 as unseen, and orders 20 and 30, because heads at exactly 36° cannot
    observe these orders."""
    disc = Disc({1: (20.0, 0.4), 7: (1.0, 1.0)}, alpha_deg=36.0)
    counts = counts_of(disc, start=0.0)
    alpha = float(np.radians(36.0))
    asked = {"nominal_separation_rad": alpha, "separation": firmware()[1].SEPARATION_NOMINAL}
    reason, made = estimate(method, capture_in_c(counts), **asked)
    assert reason == "none"
    hidden = [place + 1 for place in range(32) if not made.harmonic[place].seen]
    assert hidden == [10, 20, 30]
    assert_equal(made, reference(method, counts, separation="nominal", alpha_rad=alpha))


@pytest.mark.parametrize("method", METHODS)
def test_heads_that_detect_the_mark_at_different_places(method: str) -> None:
    """The uncertainty of the separation covers heads that detect the mark at places 10 µm apart,
    which are 38″ or 492 counts of head 2. No data can distinguish this shift from a change of the
    separation."""
    u_detection = 38.0
    counts = counts_of()
    moved = counts + np.array([[0], [492]])
    asked = {"index_detection_arcsec": u_detection}
    _, right = estimate(method, capture_in_c(counts), **asked)
    _, wrong = estimate(method, capture_in_c(moved), **asked)
    shift = np.abs(values_of(wrong) - values_of(right)).reshape(2, -1)
    assert np.hypot(*shift)[0] > 0.02, "order 1, arcsec"
    ffi, library = firmware()
    u = [library.harmonic_uncertainty(ffi.addressof(right.harmonic[n])) for n in range(32)]
    # The shift is one standard uncertainty of the separation; both components of an order share it.
    assert (np.sqrt((shift**2).mean(axis=0)) <= np.array(u) * 1.01).all()
    noise = np.sqrt(right.u_measured_separation_rad**2 - u_index_rad(COUNTS, u_detection) ** 2)
    assert 0.0 < noise < 0.01 * ARCSEC
    _, nominal = estimate(
        method, capture_in_c(counts), separation=library.SEPARATION_NOMINAL, **asked
    )
    by_nominal = per_order(nominal, "by_separation_cosine")[0]
    by_measured = per_order(right, "by_separation_cosine")[0]
    expected = 50.0 / np.sqrt(3.0) * ARCSEC / u_index_rad(COUNTS, u_detection)
    assert by_nominal / by_measured == pytest.approx(expected, rel=1e-3)


def test_positions_that_wrap() -> None:
    """The estimate is right although the turn position register, a signed word of 32 bits, wraps
    after 128 turns."""
    counts = counts_of()
    _, plain = estimate("least_squares", capture_in_c(counts))
    counts += 127 * COUNTS + COUNTS // 2 - counts[0, 0]
    _, wrapped = estimate("least_squares", capture_in_c(counts))
    assert counts[0, -1] > 2**31 > counts[0, 0]
    expected = reference("least_squares", counts)
    assert_equal(wrapped, expected)
    assert not np.allclose(values_of(plain), values_of(wrapped))


def test_a_turn_that_does_not_divide_the_register() -> None:
    """The estimate is right with 360,000 counts per turn, of which 2³² is no multiple:
    ``angle_offset`` corrects the angle that follows from a wrapped position."""
    disc = Disc(DISC.orders, counts_per_rev=360_000)
    counts = counts_of(disc, noise=3.0, samples=3000) + 6000 * 360_000
    assert counts[0, 0] > 2**31
    offset = 2**32 % 360_000
    made = estimate(
        "least_squares", capture_in_c(counts, counts_per_rev=360_000, angle_offset=offset)
    )[1]
    assert_equal(made, reference("least_squares", counts, counts_per_rev=360_000))


def test_as_a_function_of_the_reading() -> None:
    counts = counts_of()
    ffi, library = firmware()
    _, made = estimate("fourier", capture_in_c(counts))
    before = reference("fourier", counts)
    library.estimate_as_function_of_reading(ffi.new("struct reading_workspace *"), made)
    expected = as_function_of_reading(before.orders, before.values)
    assert np.abs(values_of(made) - expected).max() < EQUAL_TO * 75.0
    # This step changes order 2 by 0.055″.
    assert np.abs(values_of(made) - before.values).max() > 0.03
    again = values_of(made)
    library.estimate_as_function_of_reading(ffi.new("struct reading_workspace *"), made)
    np.testing.assert_array_equal(values_of(made), again)


@given(
    amplitudes=st.lists(st.floats(0.0, 60.0), min_size=4, max_size=4),
    phase=st.floats(-3.0, 3.0),
    start=st.floats(-6.0, 6.0),
    samples=st.integers(200, 900),
    seed=st.integers(0, 99),
)
@hypothesis_settings(max_examples=25, deadline=None)
def test_any_disc(
    amplitudes: list[float], phase: float, start: float, samples: int, seed: int
) -> None:
    orders = {n: (a / n, phase * n) for n, a in zip((1, 2, 5, 16), amplitudes, strict=True)}
    counts = counts_of(Disc(orders), 0.5, seed, samples=samples, start=start, ripple_rad=0.001)
    for method in METHODS:
        reason, made = estimate(method, capture_in_c(counts), orders=24)
        assert reason == "none"
        assert_equal(made, reference(method, counts, 24))


def test_forty_orders_of_an_enlarged_disc() -> None:
    """The C code equals the reference although, with eight times the errors of the paper's disc,
    the approximation of the normal matrix is poor."""
    disc = Disc({1: (1200.0, 0.4), 2: (48.0, 4.2), 11: (3.0, 1.0)})
    counts = counts_of(disc, noise=3.0, samples=2000)
    reason, made = estimate("least_squares", capture_in_c(counts), orders=40)
    assert reason == "none"
    expected = reference("least_squares", counts, 40)
    assert np.abs(values_of(made) - expected.values).max() < EQUAL_TO * 600.0


def test_the_unit_circle_is_exact() -> None:
    ffi, library = firmware()
    circle = ffi.new("struct unit_circle *")
    library.unit_circle_prepare(circle)
    turns = np.concatenate([np.linspace(-2.0, 2.0, 4001), [0.0, 1.0 - 2**-53, 63.5 / 64]])
    found = [library.unit_circle_at(circle, t) for t in turns]
    expected = np.exp(2j * np.pi * np.remainder(turns, 1.0).astype(np.longdouble))
    worst = np.abs(np.array([v.re + 1j * v.im for v in found]) - expected).max()
    assert worst < 1e-15, "four roundings of numbers below 1"


@pytest.mark.parametrize("method", METHODS)
def test_a_turn_without_noise_has_no_infinite_weight(method: str) -> None:
    counts = counts_of(Disc({1: (0.0, 0.0)}), noise=0.0)
    counts[1] = counts[0] + round(33 / 360 * COUNTS)
    reason, made = estimate(method, capture_in_c(counts))
    assert reason == "none"
    assert np.abs(values_of(made)).max() < 1e-9
    assert np.isfinite(per_order(made, "variance_cosine")).all()


def test_words_are_only_read() -> None:
    held: CaptureInC = capture_in_c(counts_of(samples=600))
    before = held.words.copy()
    estimate("least_squares", held)
    np.testing.assert_array_equal(held.words, before)
    assert ARCSEC > 0
