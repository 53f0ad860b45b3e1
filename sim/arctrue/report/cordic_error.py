"""Compares the gateware's cosine with the exact cosine and with the bounds of the paper's appendix.

``python -m arctrue.report.cordic_error [FILE.png]`` draws the error.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from arctrue.gateware.harmonic_lane import lane_cosine
from arctrue.generated.number_formats import CORDIC_ITERATIONS, COSINE_WIDTH, PHASE_WIDTH
from arctrue.report.picture_file import save_picture
from arctrue.report.svg import AFTER, BEFORE, INK, LIMIT, house_style
from arctrue.studies.paper.appendix import approximation_bound, cosine_bound

SWEEP_BITS = 20
DEFAULT_FILE = Path("build/reports/cordic_error.png")
_BINS = 1024


def swept_phases(bits: int = SWEEP_BITS) -> NDArray[np.int32]:
    """Return all 2^``bits`` phases of ``bits`` bits, in 2⁻²⁴ turn."""
    return np.arange(0, 1 << PHASE_WIDTH, 1 << (PHASE_WIDTH - bits), dtype=np.int32)


def cosine_error(
    phase: NDArray[np.int32],
    cosine: NDArray[np.int32] | None = None,
    bits: int = COSINE_WIDTH,
    iterations: int = CORDIC_ITERATIONS,
) -> NDArray[np.float64]:
    """Return the gateware's cosine minus numpy's cosine, in the shape of ``phase`` (2⁻²⁴ turn).

    ``cosine``: output of the gateware with ``bits`` − 2 fraction bits; by default it is the output
    of the model.
    """
    if cosine is None:
        cosine = lane_cosine(phase, bits, iterations)
    error = cosine.astype(np.float64)
    error *= 2.0 ** (2 - bits)
    error -= np.cos(phase * (2.0 * math.pi / 2**PHASE_WIDTH))
    return error


def draw_cordic_error(
    path: Path,
    simulated: tuple[NDArray[np.int32], NDArray[np.int32]] | None = None,
) -> float:
    """Write a PNG of the error over all 2²⁰ phases, with the bounds of the paper's appendix.

    ``simulated``: phases (2⁻²⁴ turn) and cosines from the VHDL, drawn as dots. The folder of
    ``path`` is made if it does not exist. Returns the largest error of the model.
    """
    phase = swept_phases()
    error = cosine_error(phase)
    bins = error.reshape(_BINS, -1)
    middle_deg = (np.arange(_BINS) + 0.5) * (360.0 / _BINS)
    approximation = approximation_bound(CORDIC_ITERATIONS)
    bound = cosine_bound(COSINE_WIDTH, CORDIC_ITERATIONS)
    with house_style():
        figure = Figure(figsize=(9.6, 4.6), layout="constrained")
        axes = figure.subplots()
        axes.fill_between(
            middle_deg,
            bins.min(axis=1),
            bins.max(axis=1),
            color=AFTER,
            linewidth=0.9,
            label=f"model, all 2²⁰ phases: |error| ≤ {np.abs(error).max():.2e}",
        )
        if simulated is not None:
            axes.plot(
                simulated[0] * (360.0 / 2**PHASE_WIDTH),
                cosine_error(*simulated),
                linestyle="none",
                marker=".",
                markersize=1.2,
                color=INK,
                label=f"VHDL, {simulated[0].size} phases",
            )
        for sign in (-1, 1):
            axes.axhline(
                sign * approximation,
                color=LIMIT,
                linestyle=(0, (4, 3)),
                label=f"(A.1), {CORDIC_ITERATIONS} iterations: {approximation:.2e}"
                if sign > 0
                else None,
            )
            axes.axhline(
                sign * bound,
                color=BEFORE,
                label=f"(A.1) + (A.5), {COSINE_WIDTH} bits: {bound:.2e}" if sign > 0 else None,
            )
        axes.set_title("Error of the cosine")
        axes.set_xlabel("phase, °")
        axes.set_ylabel("cosine of the gateware − cos")
        axes.set_xlim(0, 360)
        axes.set_xticks(range(0, 361, 45))
        axes.set_ylim(-1.5 * bound, 1.5 * bound)
        axes.ticklabel_format(axis="y", scilimits=(0, 0), useMathText=True)
        axes.legend(loc="upper center", ncols=2)
        save_picture(figure, path)
    return float(np.abs(error).max())


def main(arguments: Sequence[str] | None = None) -> None:
    """Draw the picture and print the largest error."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", nargs="?", type=Path, default=DEFAULT_FILE, help="picture to write")
    target = parser.parse_args(arguments).file
    largest = draw_cordic_error(target)
    print(f"{target}: largest error {largest:.3e}, bound {cosine_bound():.3e}")


if __name__ == "__main__":
    main()
