"""Calculates the figures of docs/heads.md that need no simulation."""

from __future__ import annotations

from typing import Any

import numpy as np

from arctrue.calibration.head_weights import mean_weights, order_factor
from arctrue.calibration.heads_gain import order_gain
from arctrue.gateware.head_watch import STEP_COUNTS
from arctrue.generated.number_formats import CLOCK_HZ, HEADS_MAX, LANES_DEFAULT, WATCH_INTERVAL_BITS
from arctrue.studies.heads.self_calibrated_table import COUNTS_PER_REV
from arctrue.studies.revolution import ECCENTRICITY_M
from arctrue.table import DISC_RADIUS_M

THREE_DEG = (0.0, 118.0, 237.0)
"""Places of three heads in the tests of ``test_observable_by_heads.py``."""
MOTION_ARCSEC = 1.0
SHOWN_ORDERS = (2, 3, 4, 5, 6)
WEAK_ORDERS = (3, 6)
"""Orders that heads near 120° determine poorly."""
DETECTED_CLOCKS = 20
"""Clocks from a fault to the load of a set: up to 16 in head_watch and 2 in head_failover (their
headers), rounded up."""
MISSING_COUNTS = 48
"""Preset of ``failover_missing_counts`` (firmware/application/parameters.c)."""
WATCHED_INTERVALS = 8
"""Longest comparison of head_watch, in intervals of 2**WATCH_INTERVAL_BITS clocks."""
AXIS_MOTION_M = 0.5e-6
"""Largest motion of the axis during one comparison for which the preset of the step is
chosen."""
RADIUS_M = 0.1
"""Radius of the disc for which the preset of the step is stated."""
SPEED_DEG_S = 90.0
SLOW_DEG_S = 0.2
SLIP_COUNTS = 4000
SLIP_CLOCKS_A_COUNT = 4
"""Slip of ``sim/tests/instrument/test_failover.py``."""


def three_heads() -> dict[str, Any]:
    """Return, by order, the amplitude that an axis motion of MOTION_ARCSEC along x adds to the
    output of three heads, and the noise gains of the weak orders.

    The calibration fits the disc's order to the differences of the heads, to which the motion also
    contributes.
    """
    places = np.radians(THREE_DEG)
    weights = mean_weights(places)
    shares = {}
    for order in SHOWN_ORDERS:
        disc = np.exp(1j * order * places)
        disc = disc - disc.mean()
        motion = MOTION_ARCSEC * (np.cos(places) - np.cos(places).mean())
        taken = np.vdot(disc, motion) / np.vdot(disc, disc)
        shares[str(order)] = float(abs(order_factor(weights, places, [order])[0] * taken))
    gains = order_gain(places, WEAK_ORDERS)
    return {
        "places_deg": list(THREE_DEG),
        "motion_arcsec": MOTION_ARCSEC,
        "share_by_order": shares,
        "gain_by_order": {
            str(order): float(gain) for order, gain in zip(WEAK_ORDERS, gains, strict=True)
        },
    }


def failover_figures() -> dict[str, Any]:
    """Return times in seconds and counts of the fault table, at 2²⁴ counts per turn."""
    load_clocks = HEADS_MAX * (4 * LANES_DEFAULT + 10) + 4
    load_s = load_clocks / CLOCK_HZ
    fast, slow = (COUNTS_PER_REV * speed / 360.0 for speed in (SPEED_DEG_S, SLOW_DEG_S))
    reaction_s = DETECTED_CLOCKS / CLOCK_HZ + load_s
    watched_s = WATCHED_INTERVALS * 2**WATCH_INTERVAL_BITS / CLOCK_HZ
    counts_per_rad = COUNTS_PER_REV / (2.0 * np.pi)
    swing = 2.0 * ECCENTRICITY_M * counts_per_rad * np.radians(SPEED_DEG_S) * watched_s
    axis = 2.0 * AXIS_MOTION_M * counts_per_rad
    return {
        "load_clocks": load_clocks,
        "load_s": load_s,
        "clock_hz": CLOCK_HZ,
        "heads": HEADS_MAX,
        "lanes": LANES_DEFAULT,
        "detected_clocks": DETECTED_CLOCKS,
        "reaction_s": reaction_s,
        "missing_counts": MISSING_COUNTS,
        "missing_s": MISSING_COUNTS / fast + load_s,
        "missing_slow_s": MISSING_COUNTS / slow + load_s,
        "missing_until_swap_counts": int(np.ceil(MISSING_COUNTS + fast * load_s)),
        "step_counts": STEP_COUNTS,
        "slip_counts": SLIP_COUNTS,
        "slip_clocks_a_count": SLIP_CLOCKS_A_COUNT,
        "slip_until_swap_counts": 2 * STEP_COUNTS + reaction_s * CLOCK_HZ / SLIP_CLOCKS_A_COUNT,
        "watched_s": watched_s,
        "watched_least_s": watched_s * (WATCHED_INTERVALS - 1) / WATCHED_INTERVALS,
        "axis_motion_m": AXIS_MOTION_M,
        "eccentricity_m": ECCENTRICITY_M,
        "speed_deg_s": SPEED_DEG_S,
        "slow_deg_s": SLOW_DEG_S,
        "radius_m": RADIUS_M,
        "axis_counts": axis / RADIUS_M,
        "axis_counts_mm": axis * 1e3,
        "swing_counts": swing / RADIUS_M,
        "small_radius_m": DISC_RADIUS_M,
        "small_axis_counts": axis / DISC_RADIUS_M,
        "small_swing_counts": swing / DISC_RADIUS_M,
    }
