"""Formats numbers in reports."""

from __future__ import annotations

import math


def decimal(value: float | None, digits: int = 3) -> str:
    """Return a number as text with a true minus sign; return a dash for None, NaN and infinity."""
    if value is None or not math.isfinite(value):
        return "–"
    return f"{value:.{digits}f}".replace("-", "−")
