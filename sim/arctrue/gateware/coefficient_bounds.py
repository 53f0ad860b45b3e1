"""Computes bounds of the correction: slope, amplitude, and feedback through the measured speed."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.extension import WIDTH_ONE
from arctrue.gateware.table_conditions import nominal_speed_word
from arctrue.generated.number_formats import (
    CLOCK_HZ,
    COUNTS_PER_PERIOD,
    SPEED_FEEDBACK_EIGHTHS,
    SPEED_WINDOW_BITS,
    STEEPEST_PERCENT,
)

RANGE_STEPS = 32
"""Number of steps into which a temperature range is divided to compute bounds; the firmware uses
the same number."""
STEEPEST = STEEPEST_PERCENT / 100
"""Limit of |dε/dR| of all parts together. The corrected angle R − ε(R) moves in the direction of
the reading R if |dε/dR| < 1. The gateware calculates ε and the direction from R itself
(``stop_operator``), not from the corrected angle, so that no feedback lowers this limit."""
STEEPEST_REVERSAL = 0.5
"""Limit of the slope of the lanes with the modulator direction after a reversal, as in the
firmware: at least half of STEEPEST remains for the other parts, also of a later calibration."""
MOST_SPEED_FEEDBACK = SPEED_FEEDBACK_EIGHTHS / 8
"""Limit of :func:`speed_feedback`. If the feedback is below 1/2, the measured speed settles for any
phases of the lanes (derivation in the header of ``table_speed.vhd``)."""


def slope_and_amplitude(coefficients: Coefficients) -> tuple[float, float]:
    """Return bounds of |dε/dR| and of a lane's largest amplitude in counts, valid at any
    temperature.

    Each bound is the largest value at RANGE_STEPS + 1 temperatures of ``thermal``, plus c₂h²/4.
    This is the largest excess of a lane over its chord between two neighbours of these
    temperatures, which are h apart. Phases are ignored: Σ n·|c_n| bounds the sum of all lanes
    anywhere in the turn, also with modulators, because these are at most 1. Lanes with the
    modulator direction also change after a reversal. A set for a missing head can replace the
    lanes; the local table's slope is added to the steeper of the two.
    """
    thermal, orders = coefficients.thermal, coefficients.real_orders
    written = coefficients.amplitudes_counts * np.exp(-1j * coefficients.phases_rad)
    sizes: NDArray[np.float64]
    if thermal is None:
        sizes, bow = np.abs(written)[np.newaxis], np.zeros(coefficients.lanes)
    else:
        celsius = np.linspace(thermal.least_c, thermal.most_c, RANGE_STEPS + 1)
        gains = [
            [thermal.change_counts(order, at) for order in coefficients.orders.tolist()]
            for at in celsius.tolist()
        ]
        sizes = np.abs(written + np.array(gains) * coefficients.plain_lanes)
        step = (thermal.most_c - thermal.least_c) / RANGE_STEPS
        bow = np.array([thermal.curve_counts(order) for order in coefficients.orders.tolist()])
        bow *= step**2 / 4.0 * coefficients.plain_lanes
    largest = float((sizes + bow).max())
    slope = float((sizes @ orders).max() + bow @ orders)
    slope *= 2.0 * math.pi / coefficients.counts_per_rev
    slope += reversal_slope(coefficients)
    if coefficients.extension is not None:
        for extent in map(slope_and_amplitude, coefficients.extension.without):
            slope, largest = max(slope, extent[0]), max(largest, extent[1])
        if coefficients.extension.local_table is not None:
            slope += coefficients.extension.local_table.steepest(coefficients.counts_per_rev)
    return slope, largest


def speed_feedback(coefficients: Coefficients, clock_hz: float = CLOCK_HZ) -> float:
    """Return a bound of |g|, for any phases of the lanes that follow the speed.

    When the measured speed changes, these lanes change the corrected angle by g times the change of
    the travel in a window. ``table_speed`` measures ω in the corrected angle, so that
    ωₙ = ω + g·(ωₙ₋₁ − ωₙ₋₂). A window lasts 2¹⁴ clocks, or one period of A and B if this is longer.
    The square of ω/ω₀ changes by up to twice the change of ω/ω₀ (ω₀: nominal speed).
    """
    if coefficients.extension is None or coefficients.extension.conditions is None:
        return 0.0
    weights = {"speed": 1.0, "speed_squared": 2.0}
    sizes = np.abs(coefficients.amplitudes_counts)
    counts = sum(
        weights.get(name, 0.0) * float(sizes[lane])
        for lane, name in coefficients.extension.modulators
    )
    nominal = nominal_speed_word(
        coefficients.extension.conditions.nominal_deg_per_s, coefficients.counts_per_rev, clock_hz
    )
    return counts / max(nominal / 2.0 ** (32 - SPEED_WINDOW_BITS), float(COUNTS_PER_PERIOD))


def reversal_slope(coefficients: Coefficients) -> float:
    """Return a bound of the |dε/dR| that the change of the direction causes after a reversal:
    Σ|A|/W over the lanes with the modulator direction."""
    extension = coefficients.extension
    if extension is None or extension.conditions is None:
        return 0.0
    named = [lane for lane, name in extension.modulators if name == "direction"]
    width_counts = extension.conditions.width / WIDTH_ONE
    return float(np.abs(coefficients.amplitudes_counts[named]).sum()) / width_counts
