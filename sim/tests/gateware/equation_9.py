"""Computes equation (9) in double precision, and the largest permitted error of the gateware."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from arctrue.gateware.coefficients import Coefficients
from arctrue.generated.number_formats import CORDIC_ITERATIONS, COSINE_WIDTH


def cosine_bound(bits: int = COSINE_WIDTH) -> float:
    """Return the bound of the cosine's error, δ_max of (A.1) plus ε_max of (A.5), as the paper
    prints both."""
    iterations = CORDIC_ITERATIONS
    gains = [
        math.prod(math.sqrt(1 + 2.0 ** (-2 * i)) for i in range(j, iterations))
        for j in range(1, iterations)
    ]
    return math.atan(2.0 ** -(iterations - 1)) + 2.0 ** (0.5 - bits) * (1 + sum(gains))


def correction_bound_counts(coefficients: Coefficients, bits: int = COSINE_WIDTH) -> float:
    """Return the bound of the correction's error: half a count for the rounding, plus the cosine's
    bound times the sum of all amplitudes."""
    return 0.5 + float(np.abs(coefficients.amplitudes_counts).sum()) * cosine_bound(bits)


def error_of_words_counts(
    coefficients: Coefficients, angle: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Return ε in counts from the words of a bank, whose phase steps need not belong to an order.

    A bank that a swap activates while it is being written can contain such a phase step.
    """
    error = np.full(angle.shape, coefficients.offset_counts)
    for step, amplitude, phase in zip(
        coefficients.phase_steps,
        coefficients.amplitudes_counts,
        coefficients.phases_rad,
        strict=True,
    ):
        # The 64-bit products wrap, but their low 48 bits are right.
        turns = (angle.astype(np.uint64) * step & np.uint64(2**48 - 1)) / 2.0**48
        error += amplitude * np.cos(2.0 * math.pi * turns + phase)
    return error
