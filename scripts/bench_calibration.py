"""The calibration against the Cramér–Rao bound and a plain FFT, the gateware against float64.

``python -m scripts.bench_calibration [--draws N]``: errors over drawn turns, and the time of one
calibration, the median of the draws with their quartiles. Times are of this machine.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from arctrue.calibration.capture_check import WholeTurns
from arctrue.calibration.fourier import fourier
from arctrue.calibration.least_squares import least_squares
from arctrue.calibration.transfer_function import noise_gain, transfer_function
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.compensation_pipeline import compensate
from arctrue.studies.paper.appendix import cosine_bound
from arctrue.table import HEAD_SEPARATION_RAD, DiscEccentricity, RotaryTable, TableState, two_heads
from arctrue.units import ARCSEC_PER_RAD, RAD_PER_ARCSEC, arcsec_per_count

Float = NDArray[np.float64]

COUNTS_PER_REV = 1 << 24
SAMPLES = 12_000
NOISE_ARCSEC = 0.1
ORDERS = np.arange(1, 33)
ECCENTRICITY_M = 37.7e-6
EVALUATED = 1 << 18
METHODS = {"least_squares": least_squares, "fourier": fourier}


def table() -> RotaryTable:
    """An eccentric disc, nothing else: its curve is known by geometry."""
    return RotaryTable(
        two_heads(),
        (DiscEccentricity(ECCENTRICITY_M, 1.0),),
        noise_rad=NOISE_ARCSEC * RAD_PER_ARCSEC,
    )


def bound_arcsec() -> float:
    """RMS over the turn that no unbiased estimate of these orders beats.

    Each head has noise s and rounding of a count; K differences have the variance 2s², and a
    component of order n has 4|TF|²s²/K.
    """
    variance = NOISE_ARCSEC**2 + arcsec_per_count(COUNTS_PER_REV) ** 2 / 12.0
    gain = noise_gain(ORDERS, HEAD_SEPARATION_RAD)
    return float(np.sqrt(4.0 * variance / SAMPLES * np.sum(gain**2)))


def plain_fft(turn: WholeTurns) -> Float:
    """(4) to (7) as they stand, in four lines: cosines, then sines, arcseconds."""
    difference = (turn.head2_counts - turn.head1_counts) * arcsec_per_count(COUNTS_PER_REV)
    lines = np.fft.rfft(difference)[ORDERS] * (2.0 / SAMPLES)
    found = lines * transfer_function(ORDERS, HEAD_SEPARATION_RAD)
    return np.concatenate((found.real, -found.imag))


def measure(draws: int, seed: int = 1) -> dict[str, tuple[float, Float]]:
    """RMS error of each way over the turn, arcseconds, and the seconds of every draw.

    The error is that against the mean of the draws, so that what a DFT takes wrong alike in every
    draw (ε(R) for ε(θ)) is not counted as noise.
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
            started = time.perf_counter()
            values[name].append(way(turn))
            times[name].append(time.perf_counter() - started)
    found = {}
    for name, drawn in values.items():
        spread = np.var(np.array(drawn), axis=0, ddof=1)
        found[name] = (float(np.sqrt(0.5 * spread.sum())), np.array(times[name]))
    return found


def gateware_difference_arcsec() -> tuple[float, float, float]:
    """Bit-true correction less equation (8) in float64: largest and RMS, and the bound."""
    amplitude, phase = np.array([1864.0, 77.7, 15.5]), np.array([1.0, 2.0, 3.0])
    coefficients = Coefficients.from_harmonics(
        np.array([1, 2, 3]), amplitude, phase, COUNTS_PER_REV
    )
    angle = np.arange(0, COUNTS_PER_REV, COUNTS_PER_REV // EVALUATED, dtype=np.int64)
    corrected = compensate(angle, np.zeros_like(angle), coefficients).corrected_angle
    exact = angle - coefficients.error_counts(angle)
    half = COUNTS_PER_REV / 2
    off = (corrected - exact + half) % COUNTS_PER_REV - half
    # A count is rounded once; the cosines are within the appendix's bound.
    most = 0.5 + cosine_bound() * float(np.sum(np.abs(amplitude))) + 2.0**-11
    unit = arcsec_per_count(COUNTS_PER_REV)
    return float(np.max(np.abs(off))) * unit, float(np.sqrt(np.mean(off**2))) * unit, most * unit


def main(arguments: Sequence[str] | None = None) -> int:
    """Print both tables; 1: the gateware leaves its bound."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--draws", type=int, default=40)
    draws = parser.parse_args(arguments).draws
    bound = bound_arcsec()
    print(f"calibration of a turn of {SAMPLES:,} samples, {ORDERS.size} orders, {draws} draws")
    print(f"{'':16}{'error, ″ RMS':>14}{'over the bound':>16}{'median ms':>11}{'quartiles ms':>20}")
    for name, (error, seconds) in measure(draws).items():
        low, middle, high = np.quantile(seconds, (0.25, 0.5, 0.75)) * 1e3
        print(
            f"{name:16}{error:14.4f}{error / bound:16.3f}{middle:11.2f}"
            f"{f'{low:.2f} to {high:.2f}':>20}"
        )
    print(f"{'Cramér–Rao bound':16}{bound:14.4f}{1.0:16.3f}")
    largest, rms, most = gateware_difference_arcsec()
    print(
        f"\ngateware less float64, {EVALUATED:,} angles: largest {largest:.4f}″ "
        f"(bound {most:.4f}″), "
        f"RMS {rms:.4f}″; eccentricity {ECCENTRICITY_M / 53.975e-3 * ARCSEC_PER_RAD:.0f}″"
    )
    return int(largest > most)


if __name__ == "__main__":
    raise SystemExit(main())
