"""Describes an uncertainty budget in words, without a picture."""

from __future__ import annotations

import math

from arctrue.metrology.budget import Budget


def freedom(value: float) -> str:
    """Return degrees of freedom as text."""
    return "∞" if math.isinf(value) else f"{value:.0f}"


def outcome(budget: Budget) -> str:
    """Return one sentence that states the combined and the expanded uncertainty."""
    lacking = "; a lower limit, because contributions are not stated" if budget.missing else ""
    return (
        f"u = {budget.u_arcsec:.4f}″, νeff = {freedom(budget.degrees_of_freedom)}, "
        f"U = {budget.expanded_arcsec:.4f}″ (k = 2{lacking}); "
        f"95.45 % needs k = {budget.coverage_factor:.2f}"
    )
