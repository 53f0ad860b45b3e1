"""Shares and probabilities in words: one way to write them."""

from __future__ import annotations


def percent(share: float, digits: int = 0) -> str:
    """``0.123`` as ``12 %``."""
    return f"{100.0 * share:.{digits}f} %"


def probability_percent(value: float) -> str:
    """A probability in per cent; never 0 % and never 100 %, which would be a certainty."""
    if value >= 0.995:
        return "above 99 %"
    if value < 0.005:
        return "below 1 %"
    return percent(value)
