"""Compares the calibration with the Cramér–Rao bound and a plain FFT, and the gateware's correction
with float64.

``python -m scripts.bench_calibration [--draws N]`` prints the RMS error of the calibration for
groups of ten simulated turns, and the processor time of single calibrations on this machine.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC, arcsec_per_count
from arctrue.calibration.capture_check import WholeTurns
from arctrue.calibration.fourier import fourier
from arctrue.calibration.least_squares import least_squares
from arctrue.calibration.transfer_function import noise_gain, transfer_function
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.compensation_pipeline import compensate
from arctrue.studies.paper.appendix import cosine_bound
from arctrue.table import HEAD_SEPARATION_RAD, DiscEccentricity, RotaryTable, TableState, two_heads
from scripts.bench_rows import Row, add_option, give_out

Float = NDArray[np.float64]

COUNTS_PER_REV = 1 << 24
SAMPLES = 12_000
NOISE_ARCSEC = 0.1
ORDERS = np.arange(1, 33)
ECCENTRICITY_M = 37.7e-6
EVALUATED = 1 << 18
METHODS = {"least_squares": least_squares, "fourier": fourier}
GROUP = 10
"""Number of draws from which one value of the RMS error is computed."""


def table() -> RotaryTable:
    """Return a table whose only error is an eccentric disc, so that the geometry gives its exact
    error curve."""
    return RotaryTable(
        two_heads(),
        (DiscEccentricity(ECCENTRICITY_M, 1.0),),
        noise_rad=NOISE_ARCSEC * RAD_PER_ARCSEC,
    )


def bound_arcsec() -> float:
    """Return the Cramér–Rao bound of the RMS error over the turn, for unbiased estimates of the
    orders in ``ORDERS``.

    Noise and rounding to a count give each reading of a head the variance s². Each of the K
    differences of the heads has the variance 2s². A component of order n has the variance
    4|TF|²s²/K; TF is the transfer function of the order.
    """
    variance = NOISE_ARCSEC**2 + arcsec_per_count(COUNTS_PER_REV) ** 2 / 12.0
    gain = noise_gain(ORDERS, HEAD_SEPARATION_RAD)
    return float(np.sqrt(4.0 * variance / SAMPLES * np.sum(gain**2)))


def plain_fft(turn: WholeTurns) -> Float:
    """Compute the error by equations (4) to (7) without further processing; return the cosines,
    then the sines, in arcseconds."""
    difference = (turn.head2_counts - turn.head1_counts) * arcsec_per_count(COUNTS_PER_REV)
    lines = np.fft.rfft(difference)[ORDERS] * (2.0 / SAMPLES)
    found = lines * transfer_function(ORDERS, HEAD_SEPARATION_RAD)
    return np.concatenate((found.real, -found.imag))


def measure(draws: int, seed: int = 1) -> dict[str, tuple[Float, Float]]:
    """Return, by method, the RMS error of every group in arcseconds and the duration of every draw.

    The error is relative to the mean of the group, so that the constant error of the DFT, which
    uses ε(R) in place of ε(θ), does not count as noise.
    """
    random = np.random.default_rng(seed)
    own = table()
    state = TableState.at_rest(np.arange(SAMPLES) * np.float64(2.0 * np.pi / SAMPLES))

    def fitted(name: str) -> Callable[[WholeTurns], Float]:
        def run(turn: WholeTurns) -> Float:
            estimate, _ = METHODS[name](
                [turn], COUNTS_PER_REV, HEAD_SEPARATION_RAD, ORDERS, "nominal"
            )
            return estimate.values

        return run

    ways = {name: fitted(name) for name in METHODS} | {"plain FFT": plain_fft}
    values: dict[str, list[Float]] = {name: [] for name in ways}
    times: dict[str, list[float]] = {name: [] for name in ways}
    for _ in range(draws):
        counts = [own.counts(head, state, random) for head in (0, 1)]
        turn = WholeTurns(0, 1, counts[0], counts[1], COUNTS_PER_REV / SAMPLES)
        for name, way in ways.items():
            started = time.process_time()
            values[name].append(way(turn))
            times[name].append(time.process_time() - started)
    found = {}
    for name, drawn in values.items():
        groups = np.array(drawn)[: draws // GROUP * GROUP].reshape(-1, GROUP, 2 * ORDERS.size)
        spread = np.var(groups, axis=1, ddof=1)
        found[name] = (np.sqrt(0.5 * spread.sum(axis=1)), np.array(times[name]))
    return found


def gateware_difference_arcsec() -> tuple[float, float, float]:
    """Return the largest and the RMS difference between the bit-true correction and equation (8) in
    float64, and the bound of the difference."""
    amplitude, phase = np.array([1864.0, 77.7, 15.5]), np.array([1.0, 2.0, 3.0])
    coefficients = Coefficients.from_harmonics(
        np.array([1, 2, 3]), amplitude, phase, COUNTS_PER_REV
    )
    angle = np.arange(0, COUNTS_PER_REV, COUNTS_PER_REV // EVALUATED, dtype=np.int64)
    corrected = compensate(angle, np.zeros_like(angle), coefficients).corrected_angle
    exact = angle - coefficients.error_counts(angle)
    half = COUNTS_PER_REV / 2
    off = (corrected - exact + half) % COUNTS_PER_REV - half
    # The bound is the rounding to a count, plus the bound of the cosines from the paper's appendix.
    most = 0.5 + cosine_bound() * float(np.sum(np.abs(amplitude))) + 2.0**-11
    unit = arcsec_per_count(COUNTS_PER_REV)
    return float(np.max(np.abs(off))) * unit, float(np.sqrt(np.mean(off**2))) * unit, most * unit


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print the rows of the bench. Exit code 1: the gateware exceeds its bound."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--draws", type=int, default=4 * GROUP, help=f"captures that are drawn ({4 * GROUP})"
    )
    add_option(parser)
    given = parser.parse_args(arguments)
    bound = bound_arcsec()
    found = measure(max(given.draws, 2 * GROUP))
    fft_ms = 1e3 * float(np.median(found["plain FFT"][1]))
    rows = []
    for name, (error, seconds) in found.items():
        what = f"{name}, {SAMPLES:,} samples, {ORDERS.size} orders"
        ratio = float(np.sqrt(np.mean(error**2))) / bound
        rows.append(
            Row(
                f"{what}: error from noise, groups of {GROUP} draws",
                "″ RMS",
                tuple(error.tolist()),
                f"Cramér–Rao bound {bound:.4f}″; all draws: {ratio:.2f} times the bound",
            )
        )
        rows.append(
            Row(
                f"{what}: processor time",
                "ms",
                tuple((1e3 * seconds).tolist()),
                f"numpy's plain FFT: {fft_ms:.2f} ms",
            )
        )
    largest, rms, most = gateware_difference_arcsec()
    rows.append(
        Row(
            f"gateware minus equation (8) in float64, {EVALUATED:,} angles: largest",
            "″",
            (largest,),
            f"bound of the formats {most:.4f}″; RMS {rms:.4f}″",
            kept=largest <= most,
        )
    )
    return give_out(rows, given.rows)


if __name__ == "__main__":
    raise SystemExit(main())
