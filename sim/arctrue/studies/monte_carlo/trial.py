"""Runs one trial: draws a table, measures and calibrates it, and compares the result with the
truth."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD, RAD_PER_ARCSEC, arcsec_per_count
from arctrue.calibration import CalibrationSettings, CaptureRefusedError, calibrate
from arctrue.calibration.estimate import Estimate
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.compensation_pipeline import compensate
from arctrue.studies.monte_carlo.inputs import Values, drawn, ellipse_m
from arctrue.studies.simulate.experiment import SLOW_RAD_S, CaptureRun, Experiment
from arctrue.studies.simulate.measured_table import MeasuredTable
from arctrue.table import (
    HEAD_SEPARATION_RAD,
    Cause,
    DiscEccentricity,
    GraduationHarmonics,
    RotaryTable,
    TableState,
    two_heads,
)
from arctrue.table.causes.bracket_expansion import BracketExpansion
from arctrue.table.causes.index_scatter import IndexScatter
from arctrue.table.causes.radial_motion import RadialMotion
from arctrue.table.causes.swinging_speed import SwingingSpeed
from arctrue.table.causes.thermal_centre import ThermalCentre
from arctrue.table.conditions import USUAL_TEMPERATURE_C, conditions_of

Float = NDArray[np.float64]

ORDERS = 32
ECCENTRICITY_UM = (20.0, 30.0)
GRADUATION_ORDERS = tuple(range(2, 21))
GRADUATION_ARCSEC = (0.02, 1.0)
PLACES = 36
"""Readings of head 1 at which the error over the turn is evaluated."""
TRUTH_ANGLES = 2048
SPARE_TURN = 0.02
PAUSE_S = 10.0


def run_trial(task: Mapping[str, Any]) -> dict[str, Any]:
    """Run one trial; ``task``: case, seed, turns (per run), runs, samples (per turn), method.

    Keys of the result: ``square`` (32,): squared deviation of cosine and sine of each order in
    units of their stated covariance; ``deviation_arcsec2``, ``variance_arcsec2`` (32,): mean of
    both components; ``turn_arcsec``, ``corrected_arcsec``, ``u_turn_arcsec`` (36,): error of the
    estimate, error after the gateware, and stated standard uncertainty over the turn; ``alpha``:
    error of the separation and its stated uncertainty, None if α is not drawn. If the capture is
    refused, the result has the reason in ``refused`` instead.
    """
    values = drawn(task["seed"], task["case"])
    table = drawn_table(task["seed"], values)
    counts = round(values["index_counts"])
    experiment = _experiment(task, values)
    measured_table = MeasuredTable(
        table,
        reference_noise_arcsec=0.0,
        index_scatter_counts=counts,
        random=np.random.default_rng([task["seed"], 2]),
    )
    measurement = measured_table.measure(experiment, title="monte carlo").measurement
    # The set states two properties of the index marks: the sensors' places and their repeatability.
    stated = replace(
        measurement.table,
        index_detection_arcsec=values["u_detection_arcsec"],
        index_repeatability_counts=math.sqrt(IndexScatter(counts).index_variance_counts2()),
    )
    measurement = replace(measurement, table=stated)
    settings = CalibrationSettings(
        method=task["method"],
        runs=tuple(range(task["runs"])),
        most_order=ORDERS,
        lanes=round(values["lanes"]),
    )
    try:
        found = calibrate(measurement, settings)
    except CaptureRefusedError as refusal:
        return {"refused": refusal.reason}
    capture = measurement.capture
    assert capture is not None
    assert capture.temperature_c is not None
    reading_rad, error_arcsec = true_error(table, float(capture.temperature_c.mean()))
    truth = components(reading_rad, error_arcsec)
    estimate = found.estimate
    off = estimate.values - truth
    square, variance = _in_stated_covariance(estimate, off)
    places = np.linspace(0.5, 0.5 + 2.0 * np.pi, PLACES, endpoint=False)
    turn, u_turn = _over_the_turn(estimate, off, places)
    separation_rad = HEAD_SEPARATION_RAD + values["separation_arcsec"] * RAD_PER_ARCSEC
    alpha = (estimate.head_separation_rad - separation_rad) * ARCSEC_PER_RAD
    u_alpha = estimate.u_head_separation_rad * ARCSEC_PER_RAD
    return {
        "square": _rounded(square),
        "deviation_arcsec2": _rounded((off**2).reshape(2, -1).mean(axis=0)),
        "variance_arcsec2": _rounded(variance),
        "turn_arcsec": _rounded(turn),
        "corrected_arcsec": _rounded(
            _left_after_gateware(found.coefficients, reading_rad, error_arcsec, places)
        ),
        "u_turn_arcsec": _rounded(u_turn),
        "alpha": _rounded([alpha, u_alpha]) if values["u_detection_arcsec"] else None,
    }


def drawn_table(seed: int, values: Values) -> RotaryTable:
    """Draw the table of a trial: ``seed`` determines the table's error, ``values`` the
    disturbances."""
    random = np.random.default_rng([seed, 0])
    low, high = np.log(GRADUATION_ARCSEC)
    arcsec = np.exp(random.uniform(low, high, len(GRADUATION_ORDERS)))
    phases = random.uniform(0.0, 2.0 * np.pi, len(GRADUATION_ORDERS))
    effects: list[Cause] = [
        DiscEccentricity(
            float(random.uniform(*ECCENTRICITY_UM)) * 1e-6, float(random.uniform(0.0, 2.0 * np.pi))
        ),
        GraduationHarmonics(
            GRADUATION_ORDERS, tuple((arcsec * RAD_PER_ARCSEC).tolist()), tuple(phases.tolist())
        ),
    ]
    heads = two_heads(
        separation_rad=HEAD_SEPARATION_RAD + values["separation_arcsec"] * RAD_PER_ARCSEC
    )
    table = RotaryTable(heads, noise_rad=values["noise_arcsec"] * RAD_PER_ARCSEC)
    late_counts = round(values["detection_arcsec"] * RAD_PER_ARCSEC / table.count_rad)
    heads = (heads[0], replace(heads[1], index_offset_counts=late_counts))
    if values["ripple_percent"]:
        effects.append(
            SwingingSpeed(
                values["ripple_percent"] / 100,
                round(values["ripple_order"]),
                values["ripple_phase_rad"],
            )
        )
    if values["forward_um"] or values["backward_um"]:
        effects.append(RadialMotion(round(values["motion_order"]), *ellipse_m(values)))
    if values["warming_k"]:
        hub = cmath.rect(values["hub_um_per_k"] * 1e-6, values["hub_rad"])
        bracket = values["bracket_arcsec_per_k"] * RAD_PER_ARCSEC
        effects += [ThermalCentre(hub), BracketExpansion(1, heads[1], bracket)]
    return replace(table, heads=heads, causes=tuple(effects))


def _experiment(task: Mapping[str, Any], values: Values) -> Experiment:
    # The capture is slightly longer than the whole turns: a further sample shows that the turns are
    # complete.
    turns = task["turns"] + SPARE_TURN
    duration_s = turns * 2.0 * np.pi / SLOW_RAD_S
    whole_s = task["runs"] * (duration_s + PAUSE_S) - PAUSE_S
    runs = []
    for number in range(task["runs"]):
        start_s = number * (duration_s + PAUSE_S)
        ends = [
            USUAL_TEMPERATURE_C + values["warming_k"] * at_s / whole_s
            for at_s in (start_s, start_s + duration_s)
        ]
        samples = round(task["samples"] * turns)
        runs.append(CaptureRun(start_s, duration_s, SLOW_RAD_S, samples, (ends[0], ends[1])))
    return Experiment("monte carlo", tuple(runs), None)


def true_error(table: RotaryTable, temperature_c: float) -> tuple[Float, Float]:
    """Return readings of head 1 at evenly spaced true angles, and R₁ − θ in arcseconds, (2048,)
    each.

    The calibration should determine these values; they are computed without noise and rounding, at
    one temperature.
    """
    angle = np.linspace(0.0, 2.0 * np.pi, TRUTH_ANGLES, endpoint=False)
    state = conditions_of(TableState.at_rest(angle))
    state = replace(state, temperature_c=np.full(angle.shape, temperature_c))
    reading = table.reading_rad(0, state)
    return reading, (reading - angle) * ARCSEC_PER_RAD


def components(reading_rad: Float, error_arcsec: Float) -> Float:
    """Return the cosines, then the sines of orders 1 to 32 of the error over the reading, (64,).

    The components are (1/π)·∮ ε·e^{jnR} dR, integrated over the true angle: dR = (1 + ε′) dθ.
    """
    orders = np.arange(1, ORDERS + 1)
    spectrum = np.fft.fft(error_arcsec * RAD_PER_ARCSEC)
    slope = np.fft.ifft(1j * np.fft.fftfreq(spectrum.size, 1.0 / spectrum.size) * spectrum).real
    weighted = error_arcsec * (1.0 + slope) * (2.0 / error_arcsec.size)
    around = np.exp(1j * np.multiply.outer(orders, reading_rad)) @ weighted
    return np.concatenate([around.real, around.imag])


def _in_stated_covariance(estimate: Estimate, off: Float) -> tuple[Float, Float]:
    """Return, for each order, the squared deviation in units of its stated covariance, and the mean
    stated variance.

    An order that the heads cannot determine has an infinite stated variance: its squared deviation
    is 0.
    """
    at = np.arange(ORDERS)
    cc, ss = estimate.covariance[at, at], estimate.covariance[at + ORDERS, at + ORDERS]
    cs = estimate.covariance[at, at + ORDERS]
    cosine, sine = off[:ORDERS], off[ORDERS:]
    with np.errstate(invalid="ignore"):
        square = (ss * cosine**2 - 2.0 * cs * cosine * sine + cc * sine**2) / (cc * ss - cs**2)
    seen = np.isfinite(cc) & np.isfinite(ss)
    return np.where(seen, square, 0.0), np.where(seen, (cc + ss) / 2.0, 0.0)


def _over_the_turn(estimate: Estimate, off: Float, places: Float) -> tuple[Float, Float]:
    """Return the error of the estimate at the readings ``places``, and its stated standard
    uncertainty, arcseconds."""
    phase = np.multiply.outer(places, estimate.orders)
    waves = np.hstack([np.cos(phase), np.sin(phase)])
    variance = np.diag(estimate.covariance)
    seen = np.isfinite(variance)
    covariance = estimate.covariance[np.ix_(seen, seen)]
    columns = waves[:, seen]
    return waves @ off, np.sqrt(np.einsum("ij,jk,ik->i", columns, covariance, columns))


def _left_after_gateware(
    coefficients: Coefficients, reading_rad: Float, error_arcsec: Float, places: Float
) -> Float:
    """Return the error of the angle after a correction by the bit-true model of the gateware, mean
    removed."""
    counts_per_rev = coefficients.counts_per_rev
    turn = 2.0 * np.pi
    # The mean is computed over a whole turn of readings, at the middle of each count.
    at = np.linspace(0.0, turn, TRUTH_ANGLES, endpoint=False)
    wanted = np.concatenate([places, at])
    counts = np.floor(wanted / turn * counts_per_rev).astype(np.int64) % counts_per_rev
    shown = (counts + 0.5) * (turn / counts_per_rev)
    error = np.interp(shown, reading_rad, error_arcsec, period=turn)
    corrected = compensate(counts, np.zeros_like(counts), coefficients).corrected_angle
    half = counts_per_rev // 2
    correction = (counts - corrected + half) % counts_per_rev - half
    left = error - correction * arcsec_per_count(counts_per_rev)
    return np.asarray(left[: places.size] - left[places.size :].mean())


def _rounded(values: Float | list[float]) -> list[float]:
    # Round to seven digits, because the last bits of a sum may differ between processors.
    return [float(f"{value:.7g}") for value in values]
