"""Simulates every source of error alone and all sources together, and compares both results with
the stated covariance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, get_args

import numpy as np
from numpy.typing import NDArray

from arctrue.base.progress import ReportStep
from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.calibration.transfer_function import noise_gain, separation_slope
from arctrue.studies.error_budget import DRAWS
from arctrue.studies.error_budget.chain import (
    CENTRE_M_PER_K,
    LATENCY_S,
    NOISE_ARCSEC,
    ORDERS,
    SAMPLES,
    SCORED_ANGLES,
    TURN_RAD,
    WEAK_ORDER,
    Left,
    Method,
    Source,
    ramp_rate_arcsec_s,
    run_chain,
)
from arctrue.table import DISC_RADIUS_M, HEAD_SEPARATION_RAD

Float = NDArray[np.float64]

METHODS: tuple[Method, ...] = ("least_squares", "paper")
SHOWN_ANGLES = 72
ALL_SOURCES: tuple[Source, ...] = get_args(Source)
LATENCY_SIZE = f"{LATENCY_S * 1e9:.0f} ns from pin to pin, 30°/s"


@dataclass(frozen=True)
class SourceText:
    """Description of a source of error; ``random`` tells whether the source is random, so that its
    draws differ."""

    source: Source
    title: str
    size: str
    random: bool


SOURCES = (
    SourceText("quantisation", "quantisation of the readings", "1 count is 0.0772″", True),
    SourceText("noise", "noise of the readings", "0.1″ on each reading, 12,000 samples", True),
    SourceText("alpha", "α: place where the index is detected", "28.9″ (± 50″, rectangular)", True),
    SourceText("index", "α: index repeatability", "± 1 count per head, rectangular", True),
    SourceText("approximation", "approximation in (8)", "ε(R) in place of ε(θ)", False),
    SourceText("uneven", "uneven sampling", "speed ripple of 1.4 % at order 7", False),
    SourceText("cordic", "CORDIC", "18 bits, 16 iterations, phase with 24 bits", False),
    SourceText("coefficients", "rounding of the coefficients", "2⁻¹¹ count, 2⁻²⁴ turn", False),
    SourceText("latency", "latency × speed", LATENCY_SIZE, False),
    SourceText("ramp", "ramp after a swap", "the turn after a recalibration with noise", True),
    SourceText("subdivision", "subdivision", "1 % of offset, gain and phase in both heads", True),
    SourceText("heat", "heat between two calibrations", "0.9 µm/K, 2 K per hour, 12 s", False),
)  # fmt: skip


def error_budget(
    draws: int = DRAWS, seed: int = 1, report_step: ReportStep | None = None
) -> dict[str, Any]:
    """Compute the budget as plain values; each random source, and all sources together, are
    simulated ``draws`` times.

    Raises ValueError for fewer than two draws.
    """
    if draws < 2:
        raise ValueError(f"a scatter needs two draws or more, found {draws}")
    say = report_step or (lambda text: None)
    angle: Float = np.arange(SHOWN_ANGLES) * np.float64(TURN_RAD / SHOWN_ANGLES)
    found: dict[str, Any] = {
        "schema": 1,
        "draws": draws,
        "angle_deg": np.degrees(angle).tolist(),
        "ramp_rate_arcsec_s": ramp_rate_arcsec_s(),
        "heat_not_recalibrated_arcsec_per_k": CENTRE_M_PER_K / DISC_RADIUS_M * ARCSEC_PER_RAD,
        "methods": {},
    }
    for method in METHODS:
        exact = run_chain((), method, np.random.default_rng(seed))
        rows: list[dict[str, Any]] = []
        for number, text in enumerate(SOURCES):
            say(f"{method}: {text.title}")
            runs = [
                run_chain((text.source,), method, np.random.default_rng([seed, number, draw]))
                for draw in range(draws if text.random else 1)
            ]
            row = {"source": text.source, "title": text.title, "size": text.size, **_rms(runs)}
            if text.source == "noise":
                row["of_weak_order_arcsec"] = _of_order(runs, exact, WEAK_ORDER)
                row["expected_arcsec"] = expected_of_noise_arcsec()
            rows.append(row)
        say(f"{method}: all together")
        whole = [
            run_chain(ALL_SOURCES, method, np.random.default_rng([seed, 99, draw]))
            for draw in range(draws)
        ]
        summed = float(np.sqrt(sum(row["rms_arcsec"] ** 2 for row in rows)))
        found["methods"][method] = {
            "exact_rms_arcsec": exact.rms_arcsec,
            "sources": rows,
            "sum_arcsec": summed,
            "whole": _rms(whole),
            "by_angle": _by_angle(whole, angle),
        }
    return found


def expected_of_noise_arcsec() -> float:
    """Return the RMS error over the turn that white noise of both heads causes by the transfer
    function TF(n), equation (6).

    Cosine and sine of each order of R₂ − R₁ have the variance 2 σ² · 2 / samples.
    """
    gain = noise_gain(ORDERS, HEAD_SEPARATION_RAD)
    return float(NOISE_ARCSEC * np.sqrt(4.0 / SAMPLES * np.sum(gain**2)))


def _rms(runs: list[Left]) -> dict[str, float]:
    """Return the RMS of the remaining error over draws and angles, and the standard error of this
    RMS."""
    squares = np.array([run.rms_arcsec**2 for run in runs])
    rms = float(np.sqrt(squares.mean()))
    spread = float(squares.std(ddof=1) / np.sqrt(squares.size)) if squares.size > 1 else 0.0
    return {"rms_arcsec": rms, "u_rms_arcsec": 0.5 * spread / rms if rms else 0.0}


def _of_order(runs: list[Left], exact: Left, order: int) -> float:
    """Return the RMS over the turn of the error that the estimate has in one order."""
    at = int(np.flatnonzero(order == ORDERS)[0])
    both = np.array([at, at + ORDERS.size])
    off = np.array([run.estimate.values[both] - exact.estimate.values[both] for run in runs])
    return float(np.sqrt(0.5 * np.mean(np.sum(off**2, axis=1))))


def _by_angle(runs: list[Left], angle: Float) -> dict[str, list[float]]:
    """Return U (k = 2) at every angle, from the covariance of one calibration and from the draws.

    The covariance contains noise, quantisation and α. The draws contain all sources; the U from the
    draws is twice the root mean square error in bins around the angle.
    """
    estimate = runs[0].estimate
    total = estimate.u_error_arcsec(angle)
    slope = separation_slope(estimate.orders, estimate.values, estimate.head_separation_rad)
    turned = np.exp(1j * np.multiply.outer(angle, estimate.orders))
    of_alpha = np.abs((turned * slope).real.sum(axis=1)) * estimate.u_head_separation_rad
    bins = SCORED_ANGLES // SHOWN_ANGLES
    square = np.zeros(SHOWN_ANGLES)
    for run in runs:
        # The bins lie around the angles; the first bin begins below 0.
        turned_error = np.roll(run.error_arcsec, bins // 2)
        square += np.mean(turned_error.reshape(SHOWN_ANGLES, bins) ** 2, axis=1)
    return {
        "covariance_arcsec": (2.0 * total).tolist(),
        "of_alpha_arcsec": (2.0 * of_alpha).tolist(),
        "of_noise_arcsec": (2.0 * np.sqrt(np.maximum(total**2 - of_alpha**2, 0.0))).tolist(),
        "drawn_arcsec": (2.0 * np.sqrt(square / len(runs))).tolist(),
    }
