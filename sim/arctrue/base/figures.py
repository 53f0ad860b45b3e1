"""Formats numbers for people: minus signs, units, uncertainties and p values."""

from __future__ import annotations

from math import floor, isfinite, log10

LEAST_P = 1e-9
"""Limit below which a p value is printed as "< 1e-9", because no assumed distribution is valid so
far in its tail."""
SIGNS = (("arcsec", "″"), ("deg", "°"), ("um", "µm"), ("us", "µs"))
"""Units as model files and JSON write them, and the signs that people read."""


def figure(value: float | None, decimals: int, *, signed: bool = False) -> str:
    """Format a number with a true minus sign, and with a plus sign if ``signed``; None, NaN and
    infinity give a dash."""
    if value is None or not isfinite(value):
        return "–"
    return true_minus(f"{value:{'+' if signed else ''},.{decimals}f}")


def true_minus(text: str) -> str:
    """Replace each hyphen of the number ``text`` by the minus sign U+2212."""
    return text.replace("-", "−")


def unit_for_people(unit: str) -> str:
    """Format ``arcsec/K`` as ``″/K``, with a space in front if the unit needs one; "1" gives ""."""
    if unit == "1":
        return ""
    first, slash, rest = unit.partition("/")
    first = dict(SIGNS).get(first, first)
    # Signs of angle follow the number directly, other units after a space (SI brochure, 5.4.3).
    return f"{'' if first in ('″', '°') else ' '}{first}{slash}{rest}"


def with_uncertainty(value: float, sigma: float, unit: str) -> str:
    """Format ``0.9541″/K ± 0.0013″/K``: two digits of the standard uncertainty (GUM 7.2.6).

    An uncertainty of 100 or more is rounded to a whole number. If the uncertainty is not a positive
    finite number, the value has six significant digits.
    """
    unit = unit_for_people(unit)
    if not (isfinite(sigma) and sigma > 0.0 and isfinite(value)):
        return f"{true_minus(f'{value:.6g}')}{unit}"
    decimals = max(1 - floor(log10(sigma)), 0)
    between = unit if unit and not unit.startswith(" ") else ""
    return f"{true_minus(f'{value:.{decimals}f}')}{between} ± {sigma:.{decimals}f}{unit}"


def probability(value: float) -> str:
    """Format a p value with two significant digits; below LEAST_P as ``< 1e-9``."""
    return f"< {LEAST_P:.0e}".replace("e-0", "e-") if value < LEAST_P else f"{value:.2g}"
