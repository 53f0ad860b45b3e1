"""Rates with their intervals, and how well stated probabilities hold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import binomtest

CONFIDENCE = 0.95
BINS = 10


@dataclass(frozen=True, slots=True)
class Rate:
    """``hits`` of ``of``, with the Clopper–Pearson interval of 95 %."""

    hits: int
    of: int

    @property
    def interval(self) -> tuple[float, float]:
        """Lower and upper limit; 0 … 1 where nothing was tried."""
        if not self.of:
            return 0.0, 1.0
        found = binomtest(self.hits, self.of).proportion_ci(CONFIDENCE, method="exact")
        return float(found.low), float(found.high)

    def data(self) -> dict[str, float | int | None]:
        """As JSON."""
        low, high = self.interval
        share = self.hits / self.of if self.of else None
        return {"hits": self.hits, "of": self.of, "rate": share, "low": low, "high": high}

    def __str__(self) -> str:
        """``3 of 100 (3 %, 0.6 … 8.5 %)``."""
        if not self.of:
            return "no such set"
        low, high = self.interval
        return (
            f"{self.hits} of {self.of} ({100 * self.hits / self.of:.3g} %, "
            f"{100 * low:.2g} … {100 * high:.3g} %)"
        )


def rate(told: Sequence[bool]) -> Rate:
    """How many are true."""
    return Rate(sum(bool(item) for item in told), len(told))


@dataclass(frozen=True, slots=True)
class Bin:
    """One bin of the reliability curve."""

    mean_probability: float
    right: Rate


def reliability(probability: Sequence[float], right: Sequence[bool]) -> list[Bin]:
    """The reliability curve over equal bins of the stated probability; empty bins are left out."""
    stated, was = np.asarray(probability, dtype=float), np.asarray(right, dtype=bool)
    at = np.minimum((stated * BINS).astype(int), BINS - 1)
    return [
        Bin(float(stated[at == number].mean()), rate(was[at == number].tolist()))
        for number in range(BINS)
        if np.any(at == number)
    ]


def expected_calibration_error(bins: Sequence[Bin]) -> float:
    """Mean distance of stated probability and rate, weighted by the sets of each bin."""
    whole = sum(item.right.of for item in bins)
    gaps = [
        item.right.of * abs(item.mean_probability - item.right.hits / item.right.of)
        for item in bins
    ]
    return sum(gaps) / whole if whole else float("nan")
