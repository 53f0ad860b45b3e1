"""Computes the rows of the tables in docs/heads.md, as plain values."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.base.progress import ReportStep
from arctrue.base.units import ARCSEC_PER_RAD, ARCSEC_PER_TURN, RAD_PER_ARCSEC
from arctrue.calibration.capture_check import WholeTurns
from arctrue.calibration.heads_data import HeadsSettings
from arctrue.calibration.heads_gain import MotionOrders, order_gain
from arctrue.calibration.heads_least_squares import heads_least_squares
from arctrue.calibration.mean_banks import mean_banks
from arctrue.calibration.moved_head import moved_heads
from arctrue.studies.heads.budget import budget
from arctrue.studies.heads.figures import failover_figures, three_heads
from arctrue.studies.heads.self_calibrated_table import (
    COUNTS_PER_REV,
    PLACES_DEG,
    TWO_DEG,
    U_MOUNTING_ARCSEC,
    SelfCalibratedTable,
    mean_left_arcsec,
    rms,
    two_heads_left_arcsec,
)
from arctrue.table import (
    DISC_RADIUS_M,
    Cause,
    DiscEccentricity,
    RotaryTable,
    TableState,
)
from arctrue.table.causes.ball_pass import BallPass
from arctrue.table.causes.graduation_harmonics import GraduationHarmonics
from arctrue.table.causes.radial_motion import RadialMotion

Float = NDArray[np.float64]

BALL_PASS_M = 0.25e-6
BALLS = BallPass(4.37, BALL_PASS_M)
HUB_SHIFT_M = 2e-6
HUB_SHIFT = DiscEccentricity(HUB_SHIFT_M, 0.8)
"""Shift of the disc's centre relative to the axis; heat causes this shift."""
AXIS_SHIFT = RadialMotion(0, HUB_SHIFT_M * np.exp(0.8j))
AXIS: tuple[Cause, ...] = (
    BALLS,
    RadialMotion.along(2, 0.1e-6, 0.6, 1.0),
    RadialMotion(3, 0.05e-6 + 0j),
)
RADIUS_TOLERANCE_M = 1e-4
MOVED_ARCSEC = 100.0
AXIS_LIMIT_M = 5e-6
FINE_ORDERS = 500
FINE_PLACES_DEG = (0.0, 112.1, 174.8, 297.8)
"""Best of 18,000 random sets of places: smallest RMS gain of orders 2 to 500 if the motion is
unknown at every order. A set counts only if a mean exists and the heads have room; a set that was
not drawn may be better."""
AVERAGED_SAMPLES = 20
TIME_MEASUREMENT_ARCSEC = 0.006
"""Published uncertainty of time measurement on a free spin (docs/methods.md)."""
GOALS = {
    "attenuation": 500.0,
    "mean_arcsec": 0.06,
    "equal_radii_arcsec": 0.005,
    "unequal_radii_arcsec": 0.01,
    "motion_unknown_arcsec": 0.045,
    "axis_at_rest_arcsec": 0.012,
    "zero_arcsec": 0.05,
}
"""Goals of the study, fixed before its first run."""
TURNS_SHOWN = (1, 3, 10, 30, 100, 1000)


def shown(
    *,
    samples_a_turn: int = 12_000,
    fine_orders: int = FINE_ORDERS,
    fine_turns: int = 10,
    seed: int = 1,
    report_step: ReportStep | None = None,
) -> dict[str, Any]:
    """Return the rows of all tables; smaller ``samples_a_turn`` and ``fine_orders`` make a test
    faster."""
    report_step = report_step or (lambda _: None)
    table = SelfCalibratedTable(samples_a_turn=samples_a_turn, seed=seed)
    two = replace(table, places_deg=TWO_DEG)
    report_step("ball pass")
    found: dict[str, Any] = {
        "schema": 1,
        "places_deg": list(PLACES_DEG),
        "samples_a_turn": samples_a_turn,
        "seed": seed,
        "settings": _settings(table),
        "goals": GOALS,
        "ball_pass": _ball_pass(table, two),
    }
    report_step("the hub moves")
    found["hub_shift"] = [
        _hub_shift(replace(table, radius_tolerance_m=tolerance), two)
        for tolerance in (0.0, RADIUS_TOLERANCE_M)
    ]
    report_step("a head is missing")
    found["missing"] = _missing(table)
    report_step("a head moves")
    found["moved"] = [_moved(table, head) for head in range(1, 5)]
    report_step("the error function")
    found["error_function"] = _error_function(table, fine_orders, fine_turns)
    report_step("uncertainty by cause")
    found["budget"] = budget(table, HUB_SHIFT_M, RADIUS_TOLERANCE_M)
    found["three_heads"] = three_heads()
    found["failover"] = failover_figures()
    return found


def _settings(table: SelfCalibratedTable) -> dict[str, Any]:
    """Return the settings that the page states."""
    return {
        "two_places_deg": list(TWO_DEG),
        "noise_arcsec": table.noise_arcsec,
        "mounting_arcsec": table.mounting_arcsec,
        "count_arcsec": ARCSEC_PER_RAD * 2.0 * np.pi / COUNTS_PER_REV,
        "ball_pass_m": BALL_PASS_M,
        "shift_m": HUB_SHIFT_M,
        "radius_tolerance_m": RADIUS_TOLERANCE_M,
        "averaged_samples": AVERAGED_SAMPLES,
        "moved_arcsec": MOVED_ARCSEC,
        "axis_limit_m": AXIS_LIMIT_M,
        "time_measurement_arcsec": TIME_MEASUREMENT_ARCSEC,
    }


def _ball_pass(table: SelfCalibratedTable, two: SelfCalibratedTable) -> dict[str, Any]:
    """Calibrate while the axis moves, once with four heads and once with two; return the errors in
    another turn."""
    moving, pair = replace(table, axis=AXIS), replace(two, axis=AXIS)
    coefficients = moving.mean()
    quiet, angle = table.turn(5, AXIS[1:], noise=False)
    balls, _ = table.turn(5, AXIS, noise=False)
    with_noise, _ = table.turn(5, AXIS)
    # Leave out the rounding to whole counts, because the rounding of four readings exceeds the
    # remaining error.
    exact = [_exact(table, 5, causes) for causes in (AXIS[1:], AXIS)]
    change = (exact[1] - exact[0]) * (ARCSEC_PER_RAD * 2.0 * np.pi / COUNTS_PER_REV)
    assert coefficients.extension is not None
    assert coefficients.extension.mean is not None
    weights = np.array(coefficients.extension.mean.weights) / 65536.0
    counts, true = pair.turn(5, AXIS)
    noiseless, _ = pair.turn(5, AXIS, noise=False)
    left = mean_left_arcsec(coefficients, with_noise, angle)
    return {
        "on_head1_rms_arcsec": rms(change[0]),
        "on_mean_rms_arcsec": rms(weights @ change),
        "attenuation": rms(change[0]) / rms(weights @ change),
        "two_heads_without_noise_rms_arcsec": rms(two_heads_left_arcsec(pair, noiseless, true)),
        "two_heads_rms_arcsec": rms(two_heads_left_arcsec(pair, counts, true)),
        "mean_without_noise_rms_arcsec": rms(mean_left_arcsec(coefficients, balls, angle)),
        "mean_without_balls_rms_arcsec": rms(mean_left_arcsec(coefficients, quiet, angle)),
        "mean_rms_arcsec": rms(left),
        "mean_of_20_rms_arcsec": rms(left.reshape(-1, AVERAGED_SAMPLES).mean(axis=1)),
    }


def _exact(table: SelfCalibratedTable, number: int, causes: tuple[Cause, ...]) -> Float:
    """Return the readings, in counts, at the angles of :meth:`SelfCalibratedTable.turn`, without
    noise and rounding."""
    _, angle = table.turn(number, causes, noise=False)
    rotary: RotaryTable = table.rotary_table(*causes)
    state = TableState.at_rest(angle)
    return np.stack([rotary.reading_rad(h, state) for h in range(4)]) / rotary.count_rad


def _hub_shift(table: SelfCalibratedTable, two: SelfCalibratedTable) -> dict[str, Any]:
    """Calibrate while the axis rests, then shift the hub by 2 µm; return the errors without a new
    calibration."""
    coefficients = table.mean(())
    assert coefficients.extension is not None
    assert coefficients.extension.mean is not None
    change = _exact(table, 5, (HUB_SHIFT,)) - _exact(table, 5, ())
    change *= ARCSEC_PER_RAD * 2.0 * np.pi / COUNTS_PER_REV
    weights = np.array(coefficients.extension.mean.weights) / 65536.0
    counts, angle = table.turn(5, (HUB_SHIFT,), noise=False)
    before, _ = table.turn(5, (), noise=False)
    pair, true = two.turn(5, (HUB_SHIFT,), noise=False)
    return {
        "radius_tolerance_m": table.radius_tolerance_m,
        "on_head1_rms_arcsec": rms(change[0]),
        "on_mean_rms_arcsec": _change_of_mean(coefficients, table, change, weights),
        "mean_before_rms_arcsec": rms(mean_left_arcsec(coefficients, before, angle)),
        "mean_after_rms_arcsec": rms(mean_left_arcsec(coefficients, counts, angle)),
        "two_heads_after_rms_arcsec": rms(two_heads_left_arcsec(two, pair, true)),
    }


def _change_of_mean(
    coefficients: Any, table: SelfCalibratedTable, change: Float, weights: Float
) -> float:
    """Return the RMS change of the output that a shift of the readings causes, without rounding of
    the readings.

    The shift also changes the reading of the carrier, the head at whose reading the lanes are
    evaluated.
    """
    counts, _ = table.turn(5, (), noise=False)
    mean = coefficients.extension.mean
    carrier = counts[mean.carrier - 1] - mean.offsets[mean.carrier - 1] // 16
    unit = ARCSEC_PER_RAD * 2.0 * np.pi / COUNTS_PER_REV
    moved = np.rint(change[mean.carrier - 1] / unit).astype(np.int64)
    lanes = (coefficients.error_counts(carrier + moved) - coefficients.error_counts(carrier)) * unit
    return float(np.sqrt(np.mean((weights @ change - np.asarray(lanes)) ** 2)))


def _missing(table: SelfCalibratedTable) -> list[dict[str, Any]]:
    """Return the error of one turn after the calibration, for the mean of all four heads and for
    every mean of three of them."""
    coefficients = replace(table, axis=AXIS).mean()
    assert coefficients.extension is not None
    counts, angle = table.turn(6, AXIS)
    noiseless, _ = table.turn(6, AXIS, noise=False)
    rows = []
    whole = mean_left_arcsec(coefficients, counts, angle)
    for one in (coefficients, *coefficients.extension.without):
        assert one.extension is not None
        assert one.extension.mean is not None
        weights = np.array(one.extension.mean.weights) / 65536.0
        left = mean_left_arcsec(one, counts, angle)
        rows.append(
            {
                "missing": one.extension.mean.missing,
                "carrier": one.extension.mean.carrier,
                "weights": weights.tolist(),
                "noise": float(np.linalg.norm(weights)),
                "rms_arcsec": rms(left),
                "without_noise_rms_arcsec": rms(mean_left_arcsec(one, noiseless, angle)),
                "lanes_rms_arcsec": float(np.linalg.norm(one.amplitudes_counts) / np.sqrt(2.0))
                * ARCSEC_PER_RAD * 2.0 * np.pi / COUNTS_PER_REV,
                "zero_apart_arcsec": float(left.mean() - whole.mean()),
            }
        )  # fmt: skip
    return rows


def _moved(table: SelfCalibratedTable, head: int) -> dict[str, Any]:
    """Shift a head by 100″ along the scale, and the axis by 2 µm, between two turns; return the
    errors."""
    before = table.estimate(())
    moved = [0.0] * 4
    moved[head - 1] = MOVED_ARCSEC
    later = replace(table, moved_arcsec=tuple(moved), axis=(AXIS_SHIFT,))
    # The counters are not set to the index again, so that the reading of a moved head changes by
    # its shift.
    counts, angle = later.turn(3, (AXIS_SHIFT,))
    old, _ = table.turn(3, ())
    captured = later.captured(3)
    offsets = np.array([float(np.mean(h - captured.heads[0])) for h in captured.heads])
    unit = ARCSEC_PER_RAD * 2.0 * np.pi / COUNTS_PER_REV
    now = offsets * unit
    apart = now - before.offsets_rad * ARCSEC_PER_RAD
    apart = (apart + ARCSEC_PER_TURN / 2.0) % ARCSEC_PER_TURN - ARCSEC_PER_TURN / 2.0
    limit = AXIS_LIMIT_M / DISC_RADIUS_M * ARCSEC_PER_RAD
    found = moved_heads(
        apart,
        before.places_rad,
        before.radius_ratios,
        axis_limit_arcsec=limit,
        noise_arcsec=0.1,
    )
    disc = before.on_disc()
    left_before = mean_left_arcsec(mean_banks(disc, COUNTS_PER_REV)[0], old, angle)
    wrong = mean_left_arcsec(mean_banks(disc, COUNTS_PER_REV)[0], counts, angle)
    zero = None
    if len(found) == 1:
        shift = np.zeros(4)
        shift[found[0].head - 1] = found[0].moved_arcsec * RAD_PER_ARCSEC
        mended = replace(
            disc, places_rad=disc.places_rad + shift, offsets_rad=disc.offsets_rad + shift
        )
        right = mean_left_arcsec(mean_banks(mended, COUNTS_PER_REV)[0], counts, angle)
        zero = float(right.mean() - left_before.mean())
    return {
        "head": head,
        "found": [one.head for one in found],
        "moved_arcsec": found[0].moved_arcsec if found else None,
        "wrong_by_arcsec": float(wrong.mean() - left_before.mean()),
        "zero_after_arcsec": zero,
    }


def _error_function(table: SelfCalibratedTable, orders: int, turns: int) -> dict[str, Any]:
    """Compare the estimated error of the disc, up to a high order, with the true error; each
    result is 2σ at one angle.

    The noise gains, and therefore ``expected_2_sigma_arcsec`` and ``by_turns``, assume known places
    and index marks. ``known_places_2_sigma_arcsec`` is the result for a table whose heads and marks
    stand at their nominal places.
    """
    places = FINE_PLACES_DEG
    random = np.random.default_rng([table.seed, 13])
    further = np.arange(10, orders + 1)
    rough = GraduationHarmonics(
        tuple(further.tolist()),
        tuple((0.02 * RAD_PER_ARCSEC * random.rayleigh(size=further.size)).tolist()),
        tuple(random.uniform(-np.pi, np.pi, further.size).tolist()),
    )
    fine = replace(table, places_deg=places)
    known = replace(fine, mounting_arcsec=0.0)
    rows = []
    asked = np.arange(1, orders + 1)
    cases: tuple[tuple[str, MotionOrders, tuple[Cause, ...]], ...] = (
        ("motion unknown at every order", "every", AXIS),
        ("axis known to be at rest", (), ()),
    )
    size, part_of = fine.samples_a_turn, COUNTS_PER_REV * turns
    at = np.arange(4 * orders + 4) * np.float64(2.0 * np.pi / (4 * orders + 4))

    def left_2_sigma_arcsec(
        table: SelfCalibratedTable, causes: tuple[Cause, ...], motion: MotionOrders
    ) -> float:
        """Return the error of the estimate from all turns of a table whose axis these causes
        move."""
        counts, _ = table.turn(1, (rough, *causes), turns)
        # The samples of each turn come at the same angles, so the sum over all turns equals one
        # turn with finer counts.
        turn = counts.reshape(4, turns, size) - (
            np.arange(turns, dtype=np.int64)[:, None] * COUNTS_PER_REV
        )
        total = turn.sum(axis=1)
        estimate = heads_least_squares(
            [WholeTurns(0, 1, total[0], total[1], part_of / size, 0, tuple(total[2:]))],
            part_of,
            np.radians(places).tolist(),
            HeadsSettings(asked, motion, U_MOUNTING_ARCSEC, U_MOUNTING_ARCSEC, 0.0),
        )
        # Order 1 contains the forward circle of the axis; the mean does not contain order 1.
        wrong = estimate.on_disc().under_head(0, at) - _true_error(table, rough, at)
        lines = np.fft.rfft(wrong)
        lines[:2] = 0.0
        return 2.0 * rms(np.fft.irfft(lines, at.size))

    for title, motion, axis in cases:
        gain = order_gain(np.radians(places), asked[1:], motion)
        counts_arcsec = ARCSEC_PER_RAD * 2.0 * np.pi / COUNTS_PER_REV / np.sqrt(12.0)
        noise = np.hypot(table.noise_arcsec, counts_arcsec)
        per_turn = float(noise * np.sqrt(2.0 / size * float(np.sum(gain**2))))
        rows.append(
            {
                "title": title,
                "orders": orders,
                "turns": turns,
                "left_2_sigma_arcsec": left_2_sigma_arcsec(fine, axis, motion),
                "known_places_2_sigma_arcsec": left_2_sigma_arcsec(known, axis, motion),
                "expected_2_sigma_arcsec": 2.0 * per_turn / np.sqrt(turns),
                "largest_gain": float(gain.max()),
                # Each order has two normal components with a variance in proportion to its gain².
                "relative_scatter": float(np.linalg.norm(gain**2) / np.sum(gain**2) / 2.0),
                "by_turns": {str(n): 2.0 * per_turn / np.sqrt(n) for n in TURNS_SHOWN},
            }
        )
    return {"places_deg": list(places), "rows": rows}


def _true_error(
    table: SelfCalibratedTable, rough: GraduationHarmonics, reading_rad: Float
) -> Float:
    """Return the error g of the disc at readings of head 1, computed from the simulated table."""
    rotary = table.rotary_table(rough)
    angle = reading_rad.copy()
    for _ in range(12):
        angle += reading_rad - rotary.reading_rad(0, TableState.at_rest(angle))
    return np.asarray((reading_rad - angle) * ARCSEC_PER_RAD)
