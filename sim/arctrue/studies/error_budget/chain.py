"""Simulates one captured turn, its calibration and its correction, with selected sources of error.

If no source is selected, the chain is exact: readings with 2⁴⁰ counts per turn, no noise, a
constant speed, the known α, and a correction in double precision. A source adds its error at its
own place in the chain. If only one source is selected, this source alone causes the remaining error
of head 1.
"""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD, RAD_PER_ARCSEC, arcsec_per_count
from arctrue.calibration.capture_check import WholeTurns
from arctrue.calibration.estimate import Estimate
from arctrue.calibration.fourier import fourier
from arctrue.calibration.harmonics import error_arcsec
from arctrue.calibration.head_separation import U_DETECTION_DEFAULT_ARCSEC
from arctrue.calibration.least_squares import least_squares
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.harmonic_lane import lane_cosine
from arctrue.gateware.latency import pin_to_pin_clocks
from arctrue.generated.number_formats import CLOCK_HZ, COSINE_FRACTION, PHASE_WIDTH
from arctrue.generated.registers import REGISTERS
from arctrue.studies.revolution import (
    ECCENTRICITY_DIRECTION_RAD,
    ECCENTRICITY_M,
    GRADUATION_ARCSEC,
    GRADUATION_ORDERS,
    GRADUATION_PHASES_RAD,
)
from arctrue.table import (
    HEAD_SEPARATION_RAD,
    Cause,
    DiscEccentricity,
    GraduationHarmonics,
    Motion,
    RotaryTable,
    TableState,
    two_heads,
)
from arctrue.table.causes.signal_distortion import SignalDistortion

Float = NDArray[np.float64]
Method = Literal["least_squares", "paper"]
"""Method of calibration. ``paper``: DFT, with the approximation that ε(R) equals ε(θ);
``least_squares``: fit of ε(R) at the readings."""
Source = Literal[
    "quantisation",
    "noise",
    "alpha",
    "index",
    "approximation",
    "uneven",
    "cordic",
    "coefficients",
    "latency",
    "ramp",
    "subdivision",
    "heat",
]

TURN_RAD = 2.0 * np.pi
FULL_COUNTS, EXACT_COUNTS = 1 << 24, 1 << 40
SAMPLES = 12_000
ORDERS = np.arange(1, 17)
WEAK_ORDER, WEAK_ARCSEC = 11, 0.4
SPEED_RAD_S = math.radians(30.0)
NOISE_ARCSEC = 0.1
INDEX_COUNTS = 1.0
RIPPLE_RAD, RIPPLE_ORDER = 0.002, 7
LATENCY_S = pin_to_pin_clocks()[1] / CLOCK_HZ
"""Delay from an edge of head 1 at its pin to the corrected edge at the output pin, in seconds."""
LINES = 16384
DISTORTION = 0.01
"""Size of the errors in the sine and cosine signals of a head: offset 1 %, gain difference 1 %,
phase error 0.01 rad."""
CENTRE_M_PER_K, ROOM_K_PER_S = 0.9e-6, 2.0 / 3600.0
"""Displacement of the disc's centre per kelvin, and rate of the room's temperature: the paper's 2 K
in an hour."""
CALIBRATION_AGE_S = 12.0
"""Age of the coefficients at the end of the turn that they correct; the table turns at 30°/s."""
SCORED_ANGLES = 7200


@dataclass(frozen=True)
class Left:
    """Error of head 1 that remains after the correction; ``error_arcsec`` (angles,), mean
    removed."""

    angle_rad: Float
    error_arcsec: Float
    offset_arcsec: float
    """Constant part of the error from the latency: minus the angle that the table travels during
    the latency. Setting the table's zero at rest does not remove this part.
    """
    estimate: Estimate

    @property
    def rms_arcsec(self) -> float:
        """Return the RMS over the turn of the remaining error, including its offset."""
        return float(np.sqrt(np.mean(self.error_arcsec**2) + self.offset_arcsec**2))


def disc() -> tuple[Cause, ...]:
    """Return the disc of ``arctrue revolution`` with an additional order 11."""
    return (
        DiscEccentricity(ECCENTRICITY_M, ECCENTRICITY_DIRECTION_RAD),
        GraduationHarmonics(
            (*GRADUATION_ORDERS, WEAK_ORDER),
            tuple(a * RAD_PER_ARCSEC for a in (*GRADUATION_ARCSEC, WEAK_ARCSEC)),
            (*GRADUATION_PHASES_RAD, 1.0),
        ),
    )


def run_chain(
    sources: Collection[Source],
    method: Method,
    random: np.random.Generator,
) -> Left:
    """Capture a turn, calibrate, correct, and compute the remaining error at random angles around
    the turn."""
    counts_per_rev = FULL_COUNTS if "quantisation" in sources else EXACT_COUNTS
    estimate = _calibrated(sources, method, random, counts_per_rev)
    steps: Float = np.arange(SCORED_ANGLES) + random.random(SCORED_ANGLES)
    angle_rad = steps * (TURN_RAD / SCORED_ANGLES)
    reading = _table(sources, counts_per_rev, warm=True).reading_rad(
        0, TableState.at_rest(angle_rad)
    )
    unit = arcsec_per_count(counts_per_rev)
    if "quantisation" in sources:
        reading = np.floor(reading / (TURN_RAD / counts_per_rev)) * (TURN_RAD / counts_per_rev)
    correction = _correction(sources, estimate, reading)
    if "ramp" in sources:
        before = _calibrated({"noise"}, method, random, counts_per_rev)
        correction = correction + _still_to_go(
            _correction((), before, reading) - _correction((), estimate, reading), angle_rad
        )
    corrected = reading * ARCSEC_PER_RAD - correction
    if "quantisation" in sources:
        corrected = np.round(corrected / unit) * unit
    error = corrected - angle_rad * ARCSEC_PER_RAD
    error -= error.mean()
    offset = 0.0
    if "latency" in sources:
        ripple = RIPPLE_RAD * RIPPLE_ORDER * np.cos(RIPPLE_ORDER * angle_rad)
        offset = -SPEED_RAD_S * LATENCY_S * ARCSEC_PER_RAD
        error += offset * (ripple - ripple.mean())
    return Left(angle_rad, error, offset, estimate)


def _table(sources: Collection[Source], counts_per_rev: int, *, warm: bool = False) -> RotaryTable:
    effects = list(disc())
    if warm and "heat" in sources:
        moved = CENTRE_M_PER_K * ROOM_K_PER_S * CALIBRATION_AGE_S
        effects.append(DiscEccentricity(moved, 0.4))
    if "subdivision" in sources:
        for head, sign in ((0, 1.0), (1, -1.0)):
            effects.append(
                SignalDistortion(head, LINES, sign * DISTORTION, DISTORTION, DISTORTION, DISTORTION)
            )
    return RotaryTable(
        two_heads(),
        causes=tuple(effects),
        counts_per_rev=counts_per_rev,
        noise_rad=NOISE_ARCSEC * RAD_PER_ARCSEC if "noise" in sources else 0.0,
    )


def _calibrated(
    sources: Collection[Source],
    method: Method,
    random: np.random.Generator,
    counts_per_rev: int,
) -> Estimate:
    """Estimate the error by ``method``; the method ``paper`` gives the error as a function of the
    true angle."""
    table = _table(sources, counts_per_rev)
    if method == "paper" and "uneven" not in sources:
        # The DFT assumes that the samples are at equal steps of angle.
        angle: Float = np.arange(SAMPLES) * np.float64(TURN_RAD / SAMPLES)
        state = TableState.at_rest(angle)
    else:
        motion = Motion.steady(
            SPEED_RAD_S,
            TURN_RAD / SPEED_RAD_S,
            ripple_rad=RIPPLE_RAD if "uneven" in sources else 0.0,
            ripple_order=RIPPLE_ORDER,
        )
        state = motion.state(np.arange(SAMPLES) * np.float64(motion.duration_s / SAMPLES))
    counts = [table.counts(head, state, random) for head in (0, 1)]
    off_arcsec = 0.0
    if "alpha" in sources:
        # A tolerance has a rectangular distribution: its half-width is √3 times the standard
        # uncertainty.
        half_width = math.sqrt(3.0) * U_DETECTION_DEFAULT_ARCSEC
        off_arcsec += random.uniform(-half_width, half_width)
    if "index" in sources:
        repeats = random.uniform(-INDEX_COUNTS, INDEX_COUNTS, 2)
        off_arcsec += float(repeats[1] - repeats[0]) * arcsec_per_count(FULL_COUNTS)
    counts[1] = counts[1] + round(off_arcsec / arcsec_per_count(counts_per_rev))
    turns = [WholeTurns(0, 1, counts[0], counts[1], counts_per_rev / SAMPLES)]
    fit = least_squares if method == "least_squares" else fourier
    estimate, _ = fit(
        turns,
        counts_per_rev,
        HEAD_SEPARATION_RAD,
        ORDERS,
        "measured",
        index_detection_arcsec=U_DETECTION_DEFAULT_ARCSEC if "alpha" in sources else 0.0,
    )
    return estimate


def _correction(sources: Collection[Source], estimate: Estimate, reading: Float) -> Float:
    """Return the estimated ε(R) in arcseconds, computed in the number formats that ``sources``
    select.

    In the paper's method ε is a function of the true angle. Equation (8) evaluates ε at the
    reading, which is an approximation; if this source of error is not selected, the function first
    computes the true angle from the reading.
    """
    at = reading
    if estimate.function_of == "angle" and "approximation" not in sources:
        for _ in range(4):
            at = reading - error_arcsec(estimate.orders, estimate.values, at) * RAD_PER_ARCSEC
    if not {"coefficients", "cordic"} & set(sources):
        return error_arcsec(estimate.orders, estimate.values, at)
    unit = arcsec_per_count(FULL_COUNTS)
    amplitude, phase = estimate.amplitude_arcsec / unit, estimate.phase_rad
    if "coefficients" in sources:
        held = Coefficients.from_harmonics(estimate.orders, amplitude, phase, FULL_COUNTS, 32)
        amplitude = held.amplitudes_counts[: estimate.orders.size]
        phase = held.phases_rad[: estimate.orders.size]
    turns = np.multiply.outer(at, estimate.orders.astype(np.float64)) + phase
    if "cordic" in sources:
        whole = np.rint(turns * ((1 << PHASE_WIDTH) / TURN_RAD)).astype(np.int64)
        cosine = lane_cosine((whole % (1 << PHASE_WIDTH)).astype(np.int32)) * 2.0**-COSINE_FRACTION
    else:
        cosine = np.cos(turns)
    return np.asarray(cosine @ amplitude) * unit


def ramp_rate_arcsec_s() -> float:
    """Return the rate of the gateware's ramp between two corrections, at the register's reset
    value."""
    (register,) = [one for one in REGISTERS if one.path == "ramp_rate"]
    preset = register.fields[0].reset or 0
    return preset * 2.0**-35 * CLOCK_HZ * arcsec_per_count(FULL_COUNTS)


def _still_to_go(apart_arcsec: Float, angle_rad: Float) -> Float:
    """Return the part of the change, in arcseconds, that the ramp has not yet applied at each angle
    after a swap at angle 0."""
    gone = ramp_rate_arcsec_s() * (angle_rad - angle_rad.min()) / SPEED_RAD_S
    return np.asarray(np.sign(apart_arcsec) * np.maximum(np.abs(apart_arcsec) - gone, 0.0))
