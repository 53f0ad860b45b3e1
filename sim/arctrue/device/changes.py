"""Compares a turn of a device with the turn in which its present calibration began."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from arctrue.base.units import ARCSEC_PER_DEG

FALSE_CHANGES_A_TURN = 1e-3
"""Permitted probability that a turn of an unchanged table shows at least one significant change."""


@dataclass(frozen=True, slots=True)
class Change:
    """Difference between the present value of a quantity and its value at the calibration.

    ``size_arcsec``: for an order, the length of the difference of both vectors (amplitude, phase),
    which is not negative. For the head separation, it is the difference with its sign.
    ``u_arcsec``: standard uncertainty of that difference; for an order, the standard uncertainty of
    each component (cosine, sine).
    """

    quantity: str
    size_arcsec: float
    u_arcsec: float
    significant: bool


def calibration_turn(turns: Sequence[Mapping[str, Any]]) -> int:
    """Return the index of the first turn whose telemetry counts the last swap of the coefficients.

    Each swap of the coefficients raises the telemetry's ``swaps``, already in the line of the turn
    that caused the swap. If ``turns`` contains no swap since the board's latest start, the function
    returns the first turn after this start. If ``turns`` contains no start either, the function
    returns its first turn. ``turns`` is not empty.
    """
    index = len(turns) - 1
    while index > 0:
        earlier, later = turns[index - 1], turns[index]
        if earlier.get("swaps") != later.get("swaps") or earlier["turn"] > later["turn"]:
            break
        index -= 1
    return index


def order_change(before: Sequence[float], now: Sequence[float]) -> tuple[float, float]:
    """Return size and u, arcseconds, of an order's change; arguments are rows of ``harmonics``.

    Each row contains order, amplitude, phase in radians, and u, the uncertainty of cosine and sine.
    The size is |A₂·exp(iφ₂) − A₁·exp(iφ₁)|; u is √(u₁² + u₂²).
    """
    size = abs(cmath.rect(now[1], now[2]) - cmath.rect(before[1], before[2]))
    return size, math.hypot(before[3], now[3])


def changes_since(before: Mapping[str, Any], now: Mapping[str, Any]) -> list[Change]:
    """Compare two turns of telemetry: first the head separations, then every common order.

    An order's size² / u² has a χ² distribution with 2 degrees of freedom if nothing changed, so p =
    exp(−size²/2u²). For the head separation, p is two-sided from a normal distribution. A change is
    significant if p times the number of quantities (Bonferroni) is at most FALSE_CHANGES_A_TURN.
    """
    found: list[tuple[str, float, float, float]] = []
    names = ("separation_deg", "u_separation_arcsec")
    if all(turn.get(name) is not None for turn in (before, now) for name in names):
        size = (now["separation_deg"] - before["separation_deg"]) * ARCSEC_PER_DEG
        u = math.hypot(before["u_separation_arcsec"], now["u_separation_arcsec"])
        found.append(("head separation", size, u, _two_sided(size, u)))
    earlier = {int(row[0]): row for row in before.get("harmonics", [])}
    for row in now.get("harmonics", []):
        if int(row[0]) in earlier:
            size, u = order_change(earlier[int(row[0])], row)
            p = math.exp(-0.5 * (size / u) ** 2) if u > 0.0 else float(size == 0.0)
            found.append((f"order {int(row[0])}", size, u, p))
    most = FALSE_CHANGES_A_TURN / max(len(found), 1)
    return [Change(name, size, u, p <= most) for name, size, u, p in found]


def _two_sided(size: float, u: float) -> float:
    return math.erfc(abs(size) / u / math.sqrt(2.0)) if u > 0.0 else float(size == 0.0)
