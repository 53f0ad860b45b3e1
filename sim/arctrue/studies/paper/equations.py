"""Evaluates every equation of the paper with this implementation, and returns one line of a page
for each equation."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_DEG, ARCSEC_PER_RAD, ARCSEC_PER_TURN, arcsec_per_count
from arctrue.calibration.harmonics import as_function_of_reading, error_arcsec
from arctrue.calibration.selection import significance_factor
from arctrue.calibration.transfer_function import noise_gain, transfer_function
from arctrue.gateware.harmonic_lane import lane_cosine
from arctrue.gateware.latency import pin_to_pin_clocks
from arctrue.generated.number_formats import (
    CLOCK_HZ,
    COMPENSATION_LATENCY,
    CORDIC_ITERATIONS,
    COSINE_WIDTH,
    HARMONIC_LATENCY,
    PHASE_LATENCY,
    PHASE_WIDTH,
    PIPELINE_LATENCY,
)
from arctrue.studies.paper.appendix import approximation_bound, rounding_bound
from arctrue.studies.paper.budget import mounting_eccentricity_rad, tower_difference_rad
from arctrue.studies.paper.published import PUBLISHED
from arctrue.studies.revolution import (
    ECCENTRICITY_DIRECTION_RAD,
    ECCENTRICITY_M,
    RevolutionSettings,
)
from arctrue.table import (
    DISC_RADIUS_M,
    HEAD_SEPARATION_RAD,
    DiscEccentricity,
    RotaryTable,
    TableState,
    two_heads,
)

Float = NDArray[np.float64]

ANGLES = 12_000
SPEED_DEG_S = 30.0
COUNTS_PER_REV = 1 << 24
ORDERS = np.arange(1, 33)


@dataclass(frozen=True)
class Item:
    """Line of the page: the paper's statement, the value computed here, and the command that
    reproduces it."""

    label: str
    paper: str
    here: str
    how: str
    values: dict[str, float]
    """Numbers that the text ``here`` contains, by name."""


@cache
def _geometry() -> tuple[Float, Float, Float]:
    """Return true angle, ε(θ) and ε(θ + α) in arcseconds, computed from the exact geometry."""
    table = RotaryTable(
        two_heads(), causes=(DiscEccentricity(ECCENTRICITY_M, ECCENTRICITY_DIRECTION_RAD),)
    )
    angle: Float = np.arange(ANGLES) * np.float64(2.0 * np.pi / ANGLES)
    state = TableState.at_rest(angle)
    first = (table.reading_rad(0, state) - angle) * ARCSEC_PER_RAD
    second = (table.reading_rad(1, state) - angle - HEAD_SEPARATION_RAD) * ARCSEC_PER_RAD
    return angle, first, second


def _order(values: Float, order: int) -> complex:
    return complex(np.fft.rfft(values)[order] / values.size)


def definition() -> Item:
    """Return the line for equation (1), the definition of the error."""
    _, error, _ = _geometry()
    # A servo that moves the reading to the target stops the table at the angle target − ε.
    amplitude = 2.0 * abs(_order(error, 1))
    return Item(
        "(1)",
        "ε = P(θ) − θ: actual position minus target position",
        f"ε is the reading minus the true angle. Order 1 of the table is {amplitude:.2f}″. A servo "
        "stops at target − ε, so this ε has the opposite sign",
        "[errata](errata.md#1-and-2-two-senses-of-the-error); `arctrue iso230`",
        {"amplitude_arcsec": amplitude},
    )


def readings() -> Item:
    """Return the line for equations (2) and (3), the readings of both heads."""
    angle, first, second = _geometry()
    orders = np.arange(1, 8)
    lines = np.fft.rfft(first)[orders] * (2.0 / angle.size)
    values = np.concatenate((lines.real, -lines.imag))
    ahead = error_arcsec(orders, values, angle + HEAD_SEPARATION_RAD)
    constant = np.mean(second - ahead)
    apart = float(np.max(np.abs(second - ahead - constant)))
    return Item(
        "(2), (3)",
        "R₁ = θ + ε(θ), R₂ = θ + ε(θ + α)",
        f"R₂ = θ + α + ε(θ + α); the exact geometry of points agrees within {apart:.0e}″",
        "`sim/arctrue/table`; [head geometry](architecture.md#head-geometry)",
        {"largest_difference_arcsec": apart},
    )


def difference() -> Item:
    """Return the line for equations (4) and (5), the difference of both readings."""
    _, first, second = _geometry()
    off = [
        abs(
            _order(second - first, n)
            - (np.exp(1j * n * HEAD_SEPARATION_RAD) - 1.0) * _order(first, n)
        )
        for n in range(1, 6)
    ]
    return Item(
        "(4), (5)",
        "δ₂₁ = ε(θ + α) − ε(θ), D_n = (e^{jnα} − 1) E_n",
        f"the orders of the difference, computed from the geometry, agree within {max(off):.0e}″",
        "`pytest sim/tests/calibration`",
        {"largest_difference_arcsec": float(max(off))},
    )


def transfer() -> Item:
    """Return the line for equation (6), the transfer function."""
    gain = noise_gain(np.array([1, 11, 120]), HEAD_SEPARATION_RAD)
    return Item(
        "(6)",
        "TF(n) = 1/(e^{jnα} − 1), 0 where the denominator is 0",
        f"noise gain {gain[0]:.2f} at order 1, {gain[1]:.1f} at order 11; order 120 is not "
        "determined. The calibration states the uncertainty u of each order; an order below "
        f"{significance_factor(32):.1f} u is not applied",
        "`arctrue calibrate SET`; [head angle](head-angle.md)",
        {"gain_1": float(gain[0]), "gain_11": float(gain[1]), "limit_u": significance_factor(32)},
    )


def self_calibration() -> Item:
    """Return the line for equation (7), the self-calibration."""
    angle, first, second = _geometry()
    lines = np.fft.rfft(second - first)[ORDERS] / angle.size
    found = 2.0 * lines * transfer_function(ORDERS, HEAD_SEPARATION_RAD)
    curve = error_arcsec(ORDERS, np.concatenate((found.real, -found.imag)), angle)
    left = float(np.max(np.abs(curve - (first - first.mean()))))
    return Item(
        "(7)",
        "ε = Σ D₂₁[n] TF(n) e^{jnθ}",
        f"{left:.0e}″ remain with equal steps of the true angle and without noise",
        "`arctrue calibrate SET --method fourier`",
        {"left_arcsec": left},
    )


def correction() -> Item:
    """Return the line for equation (8), the correction."""
    amplitude = 150.0
    angle: Float = np.arange(4096) * np.float64(2.0 * np.pi / 4096)
    reading = angle + amplitude * np.cos(angle) / ARCSEC_PER_RAD
    error = amplitude * np.cos(angle)
    taken = amplitude * np.cos(reading)
    second = 2.0 * abs(_order(error - taken, 2))
    orders = np.arange(1, 9)
    values = np.zeros(16)
    values[0] = amplitude
    of_reading = error_arcsec(orders, as_function_of_reading(orders, values), reading)
    left = error - of_reading
    rest = float(np.max(np.abs(left - left.mean())))
    return Item(
        "(8)",
        "θ_com = R − ε(θ) ≈ R − ε(R)",
        f"with an error of 150″ the approximation leaves {second:.3f}″ at order 2; ε as a function "
        f"of the reading leaves {rest:.0e}″",
        "[errata](errata.md#8-εr-for-εθ)",
        {"order_2_arcsec": second, "of_reading_arcsec": rest},
    )


def cosines() -> Item:
    """Return the line for equation (9), the error as a sum of cosines."""
    value = complex(-60.0, 40.0)
    angle: Float = np.arange(360) * np.float64(np.pi / 180.0)
    complex_sum = 2.0 * (value * np.exp(1j * angle)).real
    right = 2.0 * abs(value) * np.cos(angle + math.atan2(value.imag, value.real))
    printed = 2.0 * abs(value) * np.cos(angle + math.atan(value.imag / value.real))
    off = float(np.max(np.abs(complex_sum - right)))
    wrong = float(np.max(np.abs(complex_sum - printed)) / (2.0 * abs(value)))
    return Item(
        "(9)",
        "ε = a₀ + 2 Σ A_n cos(nθ + Φ_n), Φ_n = tan⁻¹(Im/Re)",
        f"with atan2, both sides are equal within {off:.0e}″; with tan⁻¹ and Re < 0, the cosine is "
        f"wrong by {wrong:.1f} amplitudes",
        "[errata](errata.md)",
        {"off_arcsec": off, "printed_off_amplitudes": wrong},
    )


def rotation() -> Item:
    """Return the line for equations (10) and (11), the rotations of the CORDIC."""

    def cosine(sign: float) -> float:
        scale = 1.0 / math.prod(math.sqrt(1.0 + 4.0**-i) for i in range(CORDIC_ITERATIONS))
        x, y, z = scale, 0.0, 1.0
        for i in range(CORDIC_ITERATIONS):
            d = -1.0 if z < 0 else 1.0
            x, y, z = (
                x - y * d * 2.0**-i,
                y + sign * x * d * 2.0**-i,
                z - d * math.atan(2.0**-i),
            )
        return x

    scale = 1.0 / math.prod(math.sqrt(1.0 + 4.0**-i) for i in range(CORDIC_ITERATIONS))
    right, printed = (abs(cosine(sign) - math.cos(1.0)) for sign in (1.0, -1.0))
    return Item(
        "(10), (11)",
        "y_{i+1} = y_i − x_i d_i 2⁻ⁱ; x₀ = 1/A_n",
        f"y_{{i+1}} = y_i + x_i d_i 2⁻ⁱ gives cos 1 within {right:.0e} (the printed equation is "
        f"wrong by {printed:.2f}); x₀ = {scale:.5f}",
        "[cordic_rotation](entities/cordic_rotation.md); [errata](errata.md)",
        {"right": right, "printed": printed, "scale": scale},
    )


def cosine() -> Item:
    """Return the line for equation (12), the cosine that the CORDIC computes."""
    phase = np.arange(0, 1 << PHASE_WIDTH, 1 << (PHASE_WIDTH - 18), dtype=np.int32)
    exact = np.cos(phase * (2.0 * math.pi / (1 << PHASE_WIDTH)))
    error = float(np.max(np.abs(lane_cosine(phase) * 2.0 ** (2 - COSINE_WIDTH) - exact)))
    return Item(
        "(12)",
        "x_n ≈ cos φ",
        f"the largest error of the bit-true cosine over 2¹⁸ phases is {error:.2e}",
        "`python -m arctrue.report.cordic_error`",
        {"largest_error": error},
    )


def instrument_terms() -> Item:
    """Return the line for equations (14) and (15), the uncertainties of the mounting and of the
    polygon's tilt."""
    fourth = ARCSEC_PER_RAD * mounting_eccentricity_rad(
        PUBLISHED.mounting_offset_m, PUBLISHED.flatness_m, PUBLISHED.face_width_m
    )
    fifth = ARCSEC_PER_RAD * tower_difference_rad(
        2.0 * np.pi / PUBLISHED.faces, PUBLISHED.tilt_arcsec / ARCSEC_PER_RAD
    )
    return Item(
        "(14), (15)",
        "u₄ = 0.0005″, u₅ = 0.0001″",
        f"{fourth:.4f}″ and {fifth:.5f}″; tests compare both with the geometry of a concave and of "
        "a tilted mirror",
        "`pytest sim/tests/studies/paper`",
        {"u4_arcsec": fourth, "u5_arcsec": fifth},
    )


def first_bound() -> Item:
    """Return the line for equation (A.1), the CORDIC's error of approximation."""
    value = approximation_bound(CORDIC_ITERATIONS)
    return Item(
        "(A.1)",
        "δ_max = arctan 2^{−(n−1)}",
        f"n = {CORDIC_ITERATIONS}: {value:.3e}",
        "[Fig. A.1](images/paper_fig_a1.svg); `arctrue paper --out`",
        {"bound": value},
    )


def accumulated() -> Item:
    """Return the line for equation (A.2), the accumulated rounding error.

    The function follows a unit error through the later rotations.
    """
    worst = 0.0
    for j in range(1, CORDIC_ITERATIONS):
        error = complex(1.0, 0.0)
        for i in range(j, CORDIC_ITERATIONS):
            error *= complex(1.0, 2.0**-i)
        product = math.prod(math.sqrt(1.0 + 4.0**-i) for i in range(j, CORDIC_ITERATIONS))
        worst = max(worst, abs(abs(error) - product))
    return Item(
        "(A.2)",
        "ε = e(n) + Σ B(j) e(j), B(j) = ∏ √(1 + 2⁻²ⁱ)",
        f"the rotations increase a unit error by the factor B(j), within {worst:.0e}; the equation "
        "omits the rounding of z",
        "[errata](errata.md#appendix-the-rounding-bound)",
        {"off": worst},
    )


def rounding_units() -> Item:
    """Return the line for equations (A.3) and (A.4), the rounding error of one rotation."""
    printed = 2.0 ** (0.5 - COSINE_WIDTH)
    right = math.sqrt(2.0) * 2.0 ** -(COSINE_WIDTH - 1)
    return Item(
        "(A.3), (A.4)",
        "\\|e(n)\\| ≤ 2^{0.5−b}",
        f"the bound is √2 · 2^{{−(b−1)}} = 2^{{1.5−b}}; for b = {COSINE_WIDTH} this is "
        f"{right:.2e}, the printed bound is {printed:.2e}",
        "[errata](errata.md)",
        {"printed": printed, "right": right},
    )


def second_bound() -> Item:
    """Return the line for equation (A.5), the bound of the rounding error."""
    bound = rounding_bound(COSINE_WIDTH, CORDIC_ITERATIONS)
    total = bound + approximation_bound(CORDIC_ITERATIONS)
    return Item(
        "(A.5)",
        "ε_max = 2^{0.5−b} (1 + Σ ∏ √(1 + 2⁻²ⁱ))",
        f"n = {CORDIC_ITERATIONS}, b = {COSINE_WIDTH}: {bound:.2e}, together with (A.1) "
        f"{total:.2e}; the implementation's error is below the printed bound",
        "[Fig. A.2](images/paper_fig_a2.svg); `arctrue paper --out`",
        {"bound": bound, "total": total},
    )


def delays() -> Item:
    """Return the line for Table 1, the delays of the units."""
    count_ns = 360e9 / COUNTS_PER_REV / SPEED_DEG_S
    clock_ns = 1e9 / CLOCK_HZ
    pins_ns = pin_to_pin_clocks()[1] * clock_ns
    travel = pins_ns * 1e-9 * SPEED_DEG_S * ARCSEC_PER_DEG
    return Item(
        "Table 1",
        "phase 5, harmonic 20, error compensation 4 clocks: together 29 clocks, 290 ns at 100 MHz; "
        "“far below the update frequency of the read head signals”",
        f"{PHASE_LATENCY}, {HARMONIC_LATENCY} and {COMPENSATION_LATENCY} clocks: together "
        f"{PIPELINE_LATENCY} clocks, {PIPELINE_LATENCY * clock_ns:.0f} ns. A count at "
        f"{SPEED_DEG_S:g}°/s lasts {count_ns:.0f} ns; the delay is not far below this time, but "
        f"{PIPELINE_LATENCY * clock_ns / count_ns:.2f} times as long. From pin to pin the delay is "
        f"{pins_ns:.0f} ns, {travel:.3f}″ of travel",
        "`pytest tb/core/test_pin_to_pin.py`; [timing](timing.md)",
        {
            "count_ns": count_ns,
            "pipeline_ns": PIPELINE_LATENCY * clock_ns,
            "pin_to_pin_ns": pins_ns,
            "travel_arcsec": travel,
        },
    )


def measuring_equipment() -> Item:
    """Return the line for Table 2, the measuring equipment."""
    budget = PUBLISHED.budget
    largest = max(abs(limit) for limit in PUBLISHED.before_arcsec)
    return Item(
        "Table 2",
        "autocollimator ± 1000″, ± 0.1″ (k = 2); polygon 0° to 360°, ± 0.2″ (k = 2); 20 ± 2 °C",
        f"errors with u = {budget.autocollimator_arcsec:g}″ (autocollimator) and "
        f"{budget.polygon_arcsec:g}″ (polygon) are drawn once for each face; the largest reading, "
        f"{largest:g}″, is within the range. The temperature is 20 °C; "
        "[the budget](calibration-budget.md) states the effect of ± 2 K",
        "`arctrue paper --seed N`",
        {
            "u_autocollimator_arcsec": budget.autocollimator_arcsec,
            "u_polygon_arcsec": budget.polygon_arcsec,
        },
    )


def resolution() -> Item:
    """Return the line for section 4, the resolution."""
    value = arcsec_per_count(COUNTS_PER_REV)
    eccentricity = ECCENTRICITY_M / DISC_RADIUS_M * ARCSEC_PER_RAD
    samples = RevolutionSettings().samples
    return Item(
        "section 4",
        "resolution 0.772″; 12,000 points, ≈ 108″ apart, 1 kHz",
        f"{value:.4f}″; {samples:,} points, {ARCSEC_PER_TURN / samples:g}″ apart; "
        f"an eccentricity of {ECCENTRICITY_M * 1e6:g} µm causes {eccentricity:.0f}″",
        "[errata](errata.md); `arctrue revolution`",
        {"resolution_arcsec": value, "eccentricity_arcsec": eccentricity},
    )


EQUATIONS: tuple[Callable[[], Item], ...] = (
    definition,
    readings,
    difference,
    transfer,
    self_calibration,
    correction,
    cosines,
    rotation,
    cosine,
    instrument_terms,
    first_bound,
    accumulated,
    rounding_units,
    second_bound,
    delays,
    measuring_equipment,
    resolution,
)
