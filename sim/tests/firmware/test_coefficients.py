"""Tests of the C code that chooses orders, quantises them, averages turns, applies the acceptance
gate, refuses fits without a solution, and solves symmetric equations."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sim.tests.calibration.synthetic import COUNTS, Disc
from sim.tests.firmware.calibrator import capture_in_c, estimate, per_order, values_of
from sim.tests.firmware.library import firmware
from sim.tests.firmware.test_estimates import DISC, counts_of, reference

from arctrue.calibration.selection import select_orders, significance_factor
from arctrue.gateware.coefficients import Coefficients

ARCSEC_PER_COUNT = 1_296_000 / COUNTS


def verdicts_of(made: Any, lanes: int, gain_limit: float = 50.0) -> tuple[Any, list[str]]:
    ffi, library = firmware()
    verdicts = ffi.new("enum verdict[]", library.ORDERS_MAX)
    library.select_orders(made, lanes, gain_limit, verdicts)
    names = [ffi.string(library.verdict_name(verdicts[i])).decode() for i in range(made.orders)]
    return verdicts, names


def quantised(made: Any, verdicts: Any, lanes: int, counts_per_rev: int = COUNTS) -> Any:
    ffi, library = firmware()
    coefficients = ffi.new("struct coefficients *")
    code = library.coefficients_quantise(made, verdicts, counts_per_rev, lanes, coefficients)
    return ffi.string(library.refusal_name(code)).decode(), coefficients


@pytest.fixture(scope="module")
def fitted() -> Any:
    return estimate("least_squares", capture_in_c(counts_of()))[1]


@pytest.mark.parametrize(("lanes", "gain_limit"), [(32, 50.0), (3, 50.0), (32, 5.0), (1, 2.0)])
def test_the_reference_chooses_the_same_orders(fitted: Any, lanes: int, gain_limit: float) -> None:
    expected = select_orders(reference("least_squares", counts_of()), lanes, gain_limit)
    _, names = verdicts_of(fitted, lanes, gain_limit)
    assert [name == "applied" for name in names] == [v.applied for v in expected]
    reasons = {"gain": "noise gain", "not_significant": "not significant", "no_lane": "no lane"}
    for name, verdict in zip(names, expected, strict=True):
        assert verdict.reason.startswith(reasons.get(name, "")), (name, verdict)
    assert {"applied", "not_significant"} <= set(names)


def test_an_order_that_is_not_seen_is_not_applied(fitted: Any) -> None:
    ffi, _ = firmware()
    copy = ffi.new("struct estimate *", fitted[0])
    copy.harmonic[0].seen = False
    assert verdicts_of(copy, 32)[1][0] == "not_seen"


def test_the_significance_factor() -> None:
    _, library = firmware()
    for orders in (0, 1, 32, 40):
        found = library.significance_factor(orders)
        assert found == pytest.approx(significance_factor(orders), rel=1e-12)


@pytest.mark.parametrize("counts_per_rev", [COUNTS, 360_000, 65_536])
def test_the_reference_quantises_the_same(fitted: Any, counts_per_rev: int) -> None:
    library = firmware()[1]
    verdicts, names = verdicts_of(fitted, 32)
    reason, made = quantised(fitted, verdicts, 32, counts_per_rev)
    assert reason == "none"
    applied = np.array([name == "applied" for name in names])
    values = values_of(fitted).reshape(2, -1)[:, applied]
    expected = Coefficients.from_harmonics(
        np.flatnonzero(applied) + 1,
        np.hypot(*values) / (1_296_000 / counts_per_rev),
        np.arctan2(-values[1], values[0]),
        counts_per_rev,
        32,
    )
    lanes = [made.lane[i] for i in range(made.lanes)]
    assert [
        library.coefficients_phase_step(lane.order, counts_per_rev) for lane in lanes
    ] == expected.phase_steps.tolist()
    # A value near the middle between two words may be rounded to either of them.
    assert np.abs([lane.amplitude for lane in lanes] - expected.amplitudes).max() <= 1
    offsets = np.array([lane.phase_offset for lane in lanes]) - expected.phase_offsets.astype(int)
    assert np.abs((offsets + 2**23) % 2**24 - 2**23).max() <= 1


def test_an_amplitude_that_the_gateware_does_not_hold(fitted: Any) -> None:
    ffi, library = firmware()
    copy = ffi.new("struct estimate *", fitted[0])
    verdicts, _ = verdicts_of(copy, 32)
    copy.harmonic[0].cosine = 8192.1 * ARCSEC_PER_COUNT
    assert quantised(copy, verdicts, 32)[0] == "amplitude"
    copy.harmonic[0].cosine = float("nan")
    assert quantised(copy, verdicts, 32)[0] == "amplitude"
    assert not library.estimate_is_finite(copy)


def test_a_fit_that_is_not_finite_is_refused() -> None:
    """The fit refuses a separation that is not a number (NaN), although the console cannot send
    one."""
    ffi, library = firmware()
    held = capture_in_c(counts_of(samples=600))
    asked = ffi.new("struct calibration_settings *")
    asked.nominal_separation_rad, asked.orders = float("nan"), 8
    turn, fault = ffi.new("struct turn *"), ffi.new("struct capture_fault *")
    assert library.capture_verify(held.capture, 8, turn, fault) == 0
    made, workspace = ffi.new("struct estimate *"), ffi.new("struct least_squares_workspace *")
    for separation in (library.SEPARATION_MEASURED, library.SEPARATION_NOMINAL):
        asked.separation = separation
        code = library.least_squares_estimate(workspace, turn, asked, made)
        assert code == library.REFUSED_NOT_FINITE


def test_orders_that_cannot_be_separated() -> None:
    """The fit refuses 24 orders with 24 samples per turn, because the matrix is singular."""
    ffi, library = firmware()
    held = capture_in_c(counts_of(samples=24, noise=0.0), period_clocks=0)
    turn, fault = ffi.new("struct turn *"), ffi.new("struct capture_fault *")
    assert library.capture_verify(held.capture, 5, turn, fault) == 0
    made, workspace = ffi.new("struct estimate *"), ffi.new("struct least_squares_workspace *")
    asked = ffi.new("struct calibration_settings *")
    asked.nominal_separation_rad, asked.orders = float(np.radians(33.0)), 24
    assert library.least_squares_estimate(workspace, turn, asked, made) == library.REFUSED_SINGULAR
    assert (
        library.fourier_estimate(ffi.new("struct fourier_workspace *"), turn, asked, made)
        == library.REFUSED_OVER_SPEED
    )


@pytest.mark.parametrize(
    ("eccentricity_arcsec", "reason"),
    [(3000.0, "none"), (10_000.0, "not_converged"), (15_000.0, "singular")],
)
def test_a_fit_that_does_not_converge_is_refused(eccentricity_arcsec: float, reason: str) -> None:
    """The fit refuses an eccentric disc with an error of 10,000″ (2.8°) at order 1. The difference
    of the heads then varies by 1.6°, which is a phase error of 24 · 1.6° = 38° at order 24.

    With N = 24 and δ = 1.6°, the second-order approximation of the matrix has the relative error
    (2Nδ)³/6 = 0.4. The factor |e^{jnα} − 1| of a column can be as small as 0.05, so the refinement
    diverges. With 0.3 of this eccentricity the refinement converges; with 1.5 times, the
    approximated matrix is not positive definite.
    """
    disc = Disc({1: (eccentricity_arcsec, 0.4)})
    held = capture_in_c(counts_of(disc, noise=0.0, samples=400), period_clocks=0)
    ffi, library = firmware()
    turn, fault = ffi.new("struct turn *"), ffi.new("struct capture_fault *")
    assert library.capture_verify(held.capture, 24, turn, fault) == 0
    asked = ffi.new("struct calibration_settings *")
    asked.nominal_separation_rad, asked.orders = float(np.radians(33.0)), 24
    library.turn_align(turn, asked.nominal_separation_rad)
    made, workspace = ffi.new("struct estimate *"), ffi.new("struct least_squares_workspace *")
    code = library.least_squares_estimate(workspace, turn, asked, made)
    assert ffi.string(library.refusal_name(code)).decode() == reason


def test_a_fit_takes_no_longer_than_the_watchdog_waits() -> None:
    """A fit makes at most 64 passes over the turn (PASSES_MOST); with 12,000 samples and 24 orders
    it makes at most 23 (WORK_MOST)."""
    disc = Disc({1: (7700.0, 0.4)})
    for samples, expected in ((400, "none"), (12_000, "not_converged")):
        held = capture_in_c(counts_of(disc, noise=0.0, samples=samples), period_clocks=0)
        assert estimate("least_squares", held, orders=24)[0] == expected


def turns_of(number: int, noise: float = 0.2) -> list[Any]:
    return [
        estimate("fourier", capture_in_c(counts_of(noise=noise, seed=seed, samples=1500)), 8)[1]
        for seed in range(number)
    ]


def averaged(turns: list[Any], keep: float) -> tuple[Any, Any]:
    ffi, library = firmware()
    average = ffi.new("struct average *")
    library.average_clear(average)
    for turn in turns:
        library.average_add(average, turn, keep)
    result = ffi.new("struct estimate *", turns[-1][0])
    library.average_apply(average, result)
    return average, result


def test_the_average_of_equal_weights_is_the_weighted_mean() -> None:
    turns = turns_of(6)
    average, result = averaged(turns, 1.0)
    weights = np.array([1.0 / per_order(t, "variance_cosine") for t in turns])
    cosines = np.array([per_order(t, "cosine") for t in turns])
    np.testing.assert_allclose(
        per_order(result, "cosine"), (weights * cosines).sum(0) / weights.sum(0), rtol=1e-12
    )
    np.testing.assert_allclose(per_order(result, "variance_cosine"), 1 / weights.sum(0), rtol=1e-9)
    assert average.turns == 6


@pytest.mark.parametrize("keep", [0.0, 0.5, 0.9])
def test_the_average_forgets(keep: float) -> None:
    turns = turns_of(4)
    _, result = averaged(turns, keep)
    share = [keep ** (3 - i) / per_order(turn, "variance_sine") for i, turn in enumerate(turns)]
    expected = sum(s * per_order(t, "sine") for s, t in zip(share, turns, strict=True)) / sum(share)
    np.testing.assert_allclose(per_order(result, "sine"), expected, rtol=1e-12)
    u2 = sum(s**2 * per_order(t, "variance_sine") for s, t in zip(share, turns, strict=True))
    np.testing.assert_allclose(per_order(result, "variance_sine"), u2 / sum(share) ** 2, rtol=1e-9)


def test_averaging_does_not_lessen_what_the_separation_does() -> None:
    turns = turns_of(6)
    _, result = averaged(turns, 1.0)
    np.testing.assert_array_equal(
        per_order(result, "by_separation_cosine"), per_order(turns[-1], "by_separation_cosine")
    )


def prediction(made: Any, active: Any, candidate: Any) -> Any:
    _, library = firmware()
    return library.gate_predict(made, active, candidate)


def judged(found: Any) -> str:
    ffi, library = firmware()
    held = ffi.new("struct gate_prediction *", found)
    return ffi.string(library.refusal_name(library.gate_judge(held))).decode()


def test_the_gate_lets_the_first_calibration_pass(fitted: Any) -> None:
    ffi, _ = firmware()
    _, candidate = quantised(fitted, verdicts_of(fitted, 32)[0], 32)
    found = prediction(fitted, ffi.NULL, candidate)
    assert judged(found) == "none"
    rms = np.sqrt(0.5 * sum(a**2 for a, _ in DISC.orders.values()))
    assert found.active_arcsec == pytest.approx(rms, rel=0.01)
    assert found.candidate_arcsec < 0.1


def test_the_gate_keeps_the_last_good_where_a_new_turn_is_no_better(fitted: Any) -> None:
    """The gate keeps the active coefficients if the new turn measures the unchanged disc with
    fifteen times the noise."""
    _, active = quantised(fitted, verdicts_of(fitted, 32)[0], 32)
    worse = estimate("least_squares", capture_in_c(counts_of(noise=1.5, seed=5)))[1]
    _, candidate = quantised(worse, verdicts_of(worse, 32)[0], 32)
    assert judged(prediction(worse, active, candidate)) == "not_better"


def test_the_gate_lets_a_real_change_pass(fitted: Any) -> None:
    _, active = quantised(fitted, verdicts_of(fitted, 32)[0], 32)
    moved = Disc({**DISC.orders, 1: (151.0, 0.4)})
    now = estimate("least_squares", capture_in_c(counts_of(moved, seed=6)))[1]
    _, candidate = quantised(now, verdicts_of(now, 32)[0], 32)
    found = prediction(now, active, candidate)
    assert judged(found) == "none"
    assert found.active_arcsec == pytest.approx(1.0 / np.sqrt(2.0), rel=0.1)


def test_the_gate_lets_a_change_pass_that_is_less_than_u_of_the_separation() -> None:
    """The gate accepts a change of 0.03″ in an order 1 of 150″, although the uncertainty of the
    separation makes order 1 uncertain by more, 0.037″. The error of the separation is the same in
    the active coefficients, so that it cancels in the comparison."""
    asked = {"index_detection_arcsec": 50.0 / np.sqrt(3.0)}
    made = []
    for seed, amplitude in ((3, 150.0), (6, 150.03)):
        counts = counts_of(Disc({1: (amplitude, 0.4)}), seed=seed)
        made.append(estimate("least_squares", capture_in_c(counts), 8, **asked)[1])
    (_, active), (_, candidate) = (quantised(fit, verdicts_of(fit, 8)[0], 8) for fit in made)
    found = prediction(made[1], active, candidate)
    assert judged(found) == "none"
    first = made[1].harmonic[0]
    hidden = np.hypot(first.by_separation_cosine, first.by_separation_sine)
    assert hidden > 0.03
    assert found.candidate_arcsec >= hidden / np.sqrt(2.0), (
        "the part due to u of the separation is included"
    )


def test_the_gate_refuses_too_few_lanes_after_many(fitted: Any) -> None:
    _, active = quantised(fitted, verdicts_of(fitted, 32)[0], 32)
    _, candidate = quantised(fitted, verdicts_of(fitted, 1)[0], 1)
    assert judged(prediction(fitted, active, candidate)) == "not_better"


def test_a_noisy_turn_is_refused() -> None:
    _, library = firmware()
    assert library.gate_judge_noise(0.31, 0.1, 3.0) == library.REFUSED_NOISE
    assert library.gate_judge_noise(0.29, 0.1, 3.0) == library.NOT_REFUSED
    assert library.gate_judge_noise(9.0, 0.0, 3.0) == library.NOT_REFUSED, "the first turn"


@given(
    size=st.integers(1, 12),
    seed=st.integers(0, 2**32 - 1),
)
@settings(max_examples=60, deadline=None)
def test_symmetric_equations(size: int, seed: int) -> None:
    ffi, library = firmware()
    random = np.random.default_rng(seed)
    rows = random.normal(size=(size + 4, size))
    matrix, right = rows.T @ rows, random.normal(size=size)
    packed = ffi.new("double[]", matrix[np.tril_indices(size)].tolist())
    held = ffi.new("double[]", right.tolist())
    assert library.cholesky_factor(packed, size)
    library.cholesky_solve(packed, size, held)
    condition = np.linalg.cond(matrix)
    bound = 1e-14 * condition * size  # forward error of a backward stable solution
    expected = np.linalg.solve(matrix, right)
    assert np.abs(np.array(list(held)) - expected).max() <= bound * np.abs(expected).max()
    library.cholesky_invert_factor(packed, size)
    inverse = np.linalg.inv(matrix)
    found = [
        library.cholesky_inverse_element(packed, size, int(r), int(c))
        for r, c in zip(*np.tril_indices(size), strict=True)
    ]
    assert np.abs(found - inverse[np.tril_indices(size)]).max() <= bound * np.abs(inverse).max()
