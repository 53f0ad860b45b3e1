"""Formats numbers in reports."""

from __future__ import annotations

import math
from typing import Any


def decimal(value: float | None, digits: int = 3) -> str:
    """Return a number as text with a true minus sign; return a dash for None, NaN and infinity."""
    if value is None or not math.isfinite(value):
        return "–"
    return f"{value:.{digits}f}".replace("-", "−")


def plain(value: Any) -> Any:
    """Convert numpy numbers to Python numbers, and NaN and infinity to None."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
