"""Figures on the terminal: a value with its uncertainty, a probability."""

from __future__ import annotations

from math import floor, isfinite, log10

LEAST_P = 1e-9
"""Smaller ones say no more: no distribution is known that far out."""


def with_uncertainty(value: float, sigma: float, unit: str) -> str:
    """``0.9541 ± 0.0013 arcsec``: two digits of the standard uncertainty (GUM 7.2.6).

    Without a known uncertainty the value has six digits.
    """
    unit = "" if unit == "1" else f" {unit}"
    if not (isfinite(sigma) and sigma > 0.0 and isfinite(value)):
        return f"{value:.6g}{unit}"
    decimals = max(1 - floor(log10(sigma)), 0)
    return f"{value:.{decimals}f} ± {sigma:.{decimals}f}{unit}"


def probability(value: float) -> str:
    """A p value, two digits."""
    return f"< {LEAST_P:.0e}".replace("e-0", "e-") if value < LEAST_P else f"{value:.2g}"
