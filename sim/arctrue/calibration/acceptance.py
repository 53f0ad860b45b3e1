"""Tests coefficients with the set's reference run and the firmware's rules before they are written.

Each function returns objections, one sentence each; without objections the coefficients may be
written.
"""

from __future__ import annotations

import math

import numpy as np

from arctrue.base.units import ARCSEC_PER_RAD, arcsec_per_count
from arctrue.calibration.comparison import ReferenceComparison, extent
from arctrue.calibration.estimate import Estimate
from arctrue.calibration.head_separation import BELIEVABLE_ARCSEC
from arctrue.gateware.coefficient_bounds import (
    MOST_SPEED_FEEDBACK,
    STEEPEST,
    STEEPEST_REVERSAL,
    reversal_slope,
    slope_and_amplitude,
    speed_feedback,
)
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.extension import FOLLOWED_LANES_MOST, REAL_LANES_MOST
from arctrue.gateware.lane_words import AMPLITUDE_LIMIT_COUNTS
from arctrue.generated.number_formats import CLOCK_HZ, SPEED_WINDOW_BITS


def of_comparison(comparison: ReferenceComparison | None) -> list[str]:
    """Return an objection if the correction makes the error larger in the set's own reference run.

    A rise that the scatter of the rows explains is accepted: the mean of the squared errors may
    rise by two standard errors of its change.
    """
    if comparison is None:
        return []
    before, after = extent(comparison.before_arcsec), extent(comparison.after_arcsec)
    change = comparison.after_arcsec**2 - comparison.before_arcsec**2
    rows = change.size
    error = float(change.std()) / math.sqrt(rows) if rows > 1 else 0.0
    if after.rms**2 - before.rms**2 <= 2.0 * error:
        return []
    return [
        f"against the set's own reference run the error rises from {before.rms:.3f}″ to "
        f"{after.rms:.3f}″ RMS; are the heads swapped, or does the reference belong to "
        "another table?"
    ]


def of_limits(coefficients: Coefficients) -> list[str]:
    """Return an objection for each limit of the firmware that the coefficients exceed: the firmware
    would answer ``too_steep`` or ``out_of_range`` (at any temperature of the file's range),
    ``too_many_lanes``, or ``unstable_speed``."""
    steepest, largest = slope_and_amplitude(coefficients)
    thermal = coefficients.thermal
    where = "" if thermal is None else f" between {thermal.least_c:g} and {thermal.most_c:g} °C"
    found = []
    if steepest >= STEEPEST:
        found.append(
            f"the correction is too steep: |dε/dR| reaches {steepest:.3g}{where}; at "
            f"{STEEPEST:g} or more, the corrected angle could turn back"
        )
    if largest > AMPLITUDE_LIMIT_COUNTS:
        found.append(
            f"a lane reaches {largest:.0f} counts{where}, and the gateware holds no more than "
            f"{AMPLITUDE_LIMIT_COUNTS:g}"
        )
    reversal = reversal_slope(coefficients)
    if reversal >= STEEPEST_REVERSAL:
        found.append(
            f"after a reversal the correction would change by {reversal:.3g} counts per count; the "
            f"limit is {STEEPEST_REVERSAL:g}"
        )
    extension = coefficients.extension or Extension()
    for what, number, most in (
        ("with a modulator", len(extension.modulators), FOLLOWED_LANES_MOST),
        ("of orders that are not integers", len(extension.turn_steps), REAL_LANES_MOST),
    ):
        if number > most:
            found.append(f"{number} lanes {what}, and the firmware holds no more than {most}")
    return [*found, *of_speed_feedback(coefficients)]


def of_speed_feedback(coefficients: Coefficients, clock_hz: float = CLOCK_HZ) -> list[str]:
    """Return an objection if the lanes that follow the speed would make the measurement of the
    speed unstable."""
    feedback = speed_feedback(coefficients, clock_hz)
    if feedback <= MOST_SPEED_FEEDBACK:
        return []
    most_us = 1e6 * MOST_SPEED_FEEDBACK * (1 << SPEED_WINDOW_BITS) / clock_hz
    return [
        f"the lanes that follow the speed change the corrected angle by {feedback:.3g} of the "
        "travel in 2^14 clocks at the nominal speed; the gateware measures the speed in this "
        f"angle, so the limit is {MOST_SPEED_FEEDBACK:g} (a delay of {most_us:.0f} µs): leave "
        "these lanes out, and shorten a delay at its source"
    ]


def of_separation(nominal_rad: float, measured_rad: float) -> list[str]:
    """Return an objection if the firmware would answer ``heads_exchanged``, because each head
    stands at the other head's place."""

    def far(off_rad: float) -> bool:
        return abs(math.remainder(off_rad, math.tau)) * ARCSEC_PER_RAD > BELIEVABLE_ARCSEC

    if far(measured_rad - nominal_rad) and not far(measured_rad + nominal_rad):
        return [
            f"R₂ − R₁ is {math.degrees(measured_rad):.4f}° where "
            f"{math.degrees(nominal_rad):.4f}° is expected: head1_counts and head2_counts are "
            "swapped"
        ]
    return []


def of_estimate(
    estimate: Estimate, coefficients: Coefficients, *, made_of_estimate: bool = True
) -> list[str]:
    """Return an objection if the firmware would answer ``not_better``: the expected error with the
    coefficients is not smaller than the error without them.

    Let x be an estimate with standard uncertainty u, and a the coefficients. If a does not come
    from x, |x − a|² is on average 2u² too large. If a comes from x, the remaining error is the
    error of x and the rounding of a. An amplitude A has the mean square A²/2.
    """
    seen = np.isfinite(estimate.noise_gain)
    if not (coefficients.amplitudes != 0).any():
        return []
    number = estimate.orders.size
    value = (estimate.values[:number] - 1j * estimate.values[number:])[seen]
    twice_variance = 2.0 * estimate.u_component_arcsec[seen] ** 2
    held = dict(
        zip(
            coefficients.orders.tolist(),
            coefficients.amplitudes_counts * np.exp(1j * coefficients.phases_rad),
            strict=True,
        )
    )
    unit = arcsec_per_count(coefficients.counts_per_rev)
    applied = np.array([held.get(order, 0.0) * unit for order in estimate.orders[seen].tolist()])
    before = np.maximum(np.abs(value) ** 2 - twice_variance, 0.0)
    apart = np.abs(value - applied) ** 2
    after = np.where(
        made_of_estimate & (applied != 0.0),
        apart + twice_variance,
        np.maximum(apart - twice_variance, 0.0),
    )
    if after.sum() < before.sum():
        return []
    return [
        f"the error expected with these coefficients, {math.sqrt(after.sum() / 2.0):.3f}″ RMS, is "
        f"not less than without them, {math.sqrt(before.sum() / 2.0):.3f}″"
    ]
