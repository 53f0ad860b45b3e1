"""Figures in text for people: one way to write minus signs, units, uncertainties, probabilities."""

from __future__ import annotations

from math import floor, isfinite, log10

LEAST_P = 1e-9
"""Smaller ones say no more: no distribution is known that far out."""
SIGNS = (("arcsec", "″"), ("deg", "°"), ("um", "µm"), ("us", "µs"))
"""Units of model files and JSON, and what people read."""


def figure(value: float | None, decimals: int, *, signed: bool = False) -> str:
    """A number with a true minus sign; a dash where there is none. ``signed``: a plus sign too."""
    if value is None or not isfinite(value):
        return "–"
    return true_minus(f"{value:{'+' if signed else ''},.{decimals}f}")


def true_minus(text: str) -> str:
    """The number ``text`` with the minus sign of print, U+2212."""
    return text.replace("-", "−")


def unit_for_people(unit: str) -> str:
    """``″/K`` for ``arcsec/K``, with the space that belongs before it; empty for a pure number."""
    if unit == "1":
        return ""
    first, slash, rest = unit.partition("/")
    first = dict(SIGNS).get(first, first)
    # Signs of angle stand at the number, every other unit has a space (SI brochure, 5.4.3).
    return f"{'' if first in ('″', '°') else ' '}{first}{slash}{rest}"


def with_uncertainty(value: float, sigma: float, unit: str) -> str:
    """``0.9541″/K ± 0.0013″/K``: two digits of the standard uncertainty (GUM 7.2.6).

    Without a known uncertainty the value has six digits.
    """
    unit = unit_for_people(unit)
    if not (isfinite(sigma) and sigma > 0.0 and isfinite(value)):
        return f"{true_minus(f'{value:.6g}')}{unit}"
    decimals = max(1 - floor(log10(sigma)), 0)
    between = unit if unit and not unit.startswith(" ") else ""
    return f"{true_minus(f'{value:.{decimals}f}')}{between} ± {sigma:.{decimals}f}{unit}"


def probability(value: float) -> str:
    """A p value, two digits."""
    return f"< {LEAST_P:.0e}".replace("e-0", "e-") if value < LEAST_P else f"{value:.2g}"
