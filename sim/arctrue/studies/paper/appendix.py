"""Computes bounds of the CORDIC's error by the equations of the paper's appendix."""

from __future__ import annotations

import math

from arctrue.generated.number_formats import CORDIC_ITERATIONS, COSINE_WIDTH


def approximation_bound(iterations: int = CORDIC_ITERATIONS) -> float:
    """Return δ_max of equation (A.1), in radians: the angle of the last iteration."""
    return math.atan(2.0 ** -(iterations - 1))


def rounding_bound(bits: int = COSINE_WIDTH, iterations: int = CORDIC_ITERATIONS) -> float:
    """Return ε_max of equation (A.5), in the printed form, for a width of ``bits``."""
    gains = (
        math.prod(math.sqrt(1.0 + 2.0 ** (-2 * i)) for i in range(j, iterations))
        for j in range(1, iterations)
    )
    return math.ldexp(math.sqrt(2.0), -bits) * (1.0 + sum(gains))


def cosine_bound(bits: int = COSINE_WIDTH, iterations: int = CORDIC_ITERATIONS) -> float:
    """Return (A.1) + (A.5), in the printed form: 1.18·10⁻⁴ for 16 iterations of 18 bits."""
    return approximation_bound(iterations) + rounding_bound(bits, iterations)
