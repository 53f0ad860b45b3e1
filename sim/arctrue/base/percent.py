"""Formats shares and probabilities in per cent."""

from __future__ import annotations


def percent(share: float, digits: int = 0) -> str:
    """Format ``0.123`` as ``12 %``."""
    return f"{100.0 * share:.{digits}f} %"


def probability_percent(value: float) -> str:
    """Format a probability in per cent; never as 0 % or 100 %, which would claim certainty."""
    if value >= 0.995:
        return "above 99 %"
    if value <= 0.005:  # 0.5 is rounded to the even number 0
        return "below 1 %"
    return percent(value)
