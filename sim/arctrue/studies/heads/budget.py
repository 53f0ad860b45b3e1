"""Calculates, for each cause alone, the standard uncertainty of the mean of four heads.

The test ``sim/tests/studies/heads/test_budget.py`` compares it with random draws of each cause.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from arctrue.base.units import ARCSEC_PER_DEG, ARCSEC_PER_RAD, RAD_PER_ARCSEC
from arctrue.calibration.head_weights import mean_weights, weight_words
from arctrue.gateware.mean_set import WEIGHT_ONE
from arctrue.studies.heads.self_calibrated_table import COUNTS_PER_REV, SelfCalibratedTable
from arctrue.studies.revolution import ECCENTRICITY_M
from arctrue.table import DISC_RADIUS_M

PLACE_ARCSEC = 10.0
"""Standard deviation of the place of each head: a choice, whose effect the budget states."""
SKEW_S = 10e-9
"""Standard deviation of the delay of each head: one clock of the gateware, 10 ns."""
SPEED_DEG_S = 90.0
"""Speed for the row ``skew``; the fault table uses the same speed."""
OFFSET_STEPS = 16
"""Steps of an offset per count: u24.4."""
INDEX_COUNTS = 1.0
"""Half-width of the rectangular distribution of an index mark, counts (docs/faults.md)."""
MOUNTINGS = 2000
"""Number of random mountings over which the rounding of the weights is averaged: its mean square
then has a standard deviation of about 2.5 %, and its RMS one of 1.3 %."""


def budget(
    table: SelfCalibratedTable, shift_m: float, radius_tolerance_m: float
) -> list[dict[str, Any]]:
    """Return cause and standard uncertainty; the axis moves by ``shift_m`` after the calibration.

    To first order the mean contains Σwᵢ·xᵢ if the reading of head i is wrong by xᵢ, so independent
    errors with the standard deviation s give s·√Σwᵢ². An error of a place or a radius multiplies an
    order-1 wave of the reading; the wave's RMS over the turn is its amplitude divided by √2.
    """
    extension = table.mean(()).extension
    assert extension is not None
    assert extension.mean is not None
    weights = np.array(extension.mean.weights) / WEIGHT_ONE
    noise = float(np.linalg.norm(weights))
    count = ARCSEC_PER_RAD * 2.0 * np.pi / COUNTS_PER_REV
    moved = shift_m / DISC_RADIUS_M * ARCSEC_PER_RAD / np.sqrt(2.0)
    eccentric = ECCENTRICITY_M / DISC_RADIUS_M * ARCSEC_PER_RAD / np.sqrt(2.0)
    radius = radius_tolerance_m / np.sqrt(3.0) / DISC_RADIUS_M
    rectangular = 1.0 / np.sqrt(12.0)
    axis = f"axis moves by {shift_m * 1e6:g} µm"
    radii = f"radii wrong by up to {radius_tolerance_m * 1e3:g} mm"
    rows: tuple[tuple[str, str, float], ...] = (
        (
            "noise",
            f"noise of one sample, {table.noise_arcsec:g}″ per head",
            table.noise_arcsec * noise,
        ),
        ("readings", "rounding of the heads' readings to counts", count * rectangular * noise),
        ("output", "rounding of the output to counts", count * rectangular),
        ("weights", f"rounding of the weights (s1.16), {axis}", _leak(table) * moved),
        (
            "offsets",
            "rounding of the offsets (u24.4)",
            count / OFFSET_STEPS * rectangular * noise,
        ),
        (
            "zero",
            f"zero: index marks that repeat within ± {INDEX_COUNTS:g} count",
            INDEX_COUNTS * count / np.sqrt(3.0) * noise,
        ),
        (
            "places",
            f"places wrong by {PLACE_ARCSEC:g}″, {axis}",
            PLACE_ARCSEC * RAD_PER_ARCSEC * moved * noise,
        ),
        ("radii_axis", f"{radii}, {axis}", radius * moved * noise),
        ("radii_disc", f"{radii}, order 1 of the disc", radius * eccentric * noise),
        (
            "skew",
            f"delay of each head by {SKEW_S * 1e9:g} ns at {SPEED_DEG_S:g}°/s",
            SKEW_S * SPEED_DEG_S * ARCSEC_PER_DEG * noise,
        ),
    )
    return [{"name": name, "cause": cause, "u_arcsec": float(u)} for name, cause, u in rows]


def _leak(table: SelfCalibratedTable) -> float:
    """Return the RMS share of an axis motion that the rounded weights leave in the mean, over
    mountings within the tolerance."""
    random = np.random.default_rng([table.seed, 14])
    nominal = np.radians(table.places_deg)
    size = table.mounting_arcsec * RAD_PER_ARCSEC
    squares = []
    for off in random.uniform(-size, size, (MOUNTINGS, nominal.size)):
        places = nominal + off
        words = weight_words(mean_weights(places), places)
        squares.append(abs(np.exp(1j * places) @ words / WEIGHT_ONE) ** 2)
    return float(np.sqrt(np.mean(squares)))
