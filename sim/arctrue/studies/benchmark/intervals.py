"""Computes rates with their intervals, and the calibration of the stated probabilities."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binomtest

CONFIDENCE = 0.95
BINS = 10
RESAMPLES = 1000
"""Number of bootstrap resamples; 25 resamples lie below and 25 above the 95 % interval."""
SUREST = 1e-3
"""Smallest distance from 0 and 1 to which a log score limits a probability: the benchmark has
enough sets to resolve one false answer in a thousand."""

Float = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Rate:
    """Rate of ``hits`` among ``of`` trials, with the 95 % interval of Clopper and Pearson."""

    hits: int
    of: int

    @property
    def interval(self) -> tuple[float, float]:
        """Return the lower and the upper limit of the 95 % interval; 0 and 1 if there was no
        trial."""
        if not self.of:
            return 0.0, 1.0
        found = binomtest(self.hits, self.of).proportion_ci(CONFIDENCE, method="exact")
        return float(found.low), float(found.high)

    def data(self) -> dict[str, float | int | None]:
        """Return hits, trials, rate and limits as a mapping for JSON."""
        low, high = self.interval
        share = self.hits / self.of if self.of else None
        return {"hits": self.hits, "of": self.of, "rate": share, "low": low, "high": high}

    def __str__(self) -> str:
        """Return a text such as ``3 of 100 (3 %, 0.6 … 8.5 %)``."""
        if not self.of:
            return "no such set"
        low, high = self.interval
        return (
            f"{self.hits} of {self.of} ({100 * self.hits / self.of:.3g} %, "
            f"{100 * low:.2g} … {100 * high:.3g} %)"
        )


def rate(outcomes: Sequence[bool]) -> Rate:
    """Return the rate of true elements in ``outcomes``."""
    return Rate(sum(bool(item) for item in outcomes), len(outcomes))


@dataclass(frozen=True, slots=True)
class Bin:
    """Bin of the reliability curve."""

    mean_probability: float
    right: Rate


def reliability(probability: Sequence[float] | Float, right: Sequence[bool] | Float) -> list[Bin]:
    """Compute the reliability curve over ten bins of equal count.

    The answers are sorted by stated probability. With fewer than ten answers, each answer is a bin;
    answers with equal probabilities keep the given order.
    """
    stated, was = np.asarray(probability, dtype=float), np.asarray(right, dtype=bool)
    order = np.argsort(stated, kind="stable")
    return [
        Bin(float(stated[at].mean()), rate(was[at].tolist()))
        for at in np.array_split(order, BINS)
        if at.size
    ]


def expected_calibration_error(bins: Sequence[Bin]) -> float:
    """Compute the mean distance between stated probability and rate, weighted by the number of
    answers in each bin."""
    whole = sum(item.right.of for item in bins)
    gaps = [
        item.right.of * abs(item.mean_probability - item.right.hits / item.right.of)
        for item in bins
    ]
    return sum(gaps) / whole if whole else float("nan")


@dataclass(frozen=True, slots=True)
class Estimate:
    """Quantity computed from sets, with the 95 % interval of a bootstrap over the sets."""

    value: float
    low: float
    high: float

    def data(self) -> dict[str, float]:
        """Return value and limits as a mapping for JSON."""
        return {"value": self.value, "low": self.low, "high": self.high}


def calibration_error(probability: Sequence[float], right: Sequence[bool]) -> Estimate:
    """Compute the mean distance between stated probability and rate over ten bins of equal
    count."""
    return _bootstrap(
        lambda stated, was: expected_calibration_error(reliability(stated, was)), probability, right
    )


def log_score_gain(probability: Sequence[float], right: Sequence[bool]) -> Estimate:
    """Compute the mean log score of the stated probabilities minus the mean log score of a
    constant, in nats.

    A value above 0 means that the stated probabilities are better than the constant. An answer with
    the result r ∈ {0, 1} and the stated probability p scores r·log p + (1 − r)·log(1 − p), with p
    limited to ``SUREST`` … 1 − ``SUREST``. The constant is the rate of right answers; no other
    constant has a higher mean log score.
    """

    def gain(stated: Float, was: Float) -> float:
        return _log_score(stated, was) - _log_score(np.full(was.size, was.mean()), was)

    return _bootstrap(gain, probability, right)


def _log_score(stated: Float, was: Float) -> float:
    held = np.clip(stated, SUREST, 1 - SUREST)
    return float(np.mean(np.where(was > 0.5, np.log(held), np.log1p(-held))))


def _bootstrap(
    figure: Callable[[Float, Float], float], probability: Sequence[float], right: Sequence[bool]
) -> Estimate:
    stated, was = np.asarray(probability, dtype=float), np.asarray(right, dtype=float)
    random = np.random.default_rng(0)
    drawn = [
        figure(stated[at], was[at])
        for at in random.integers(0, stated.size, (RESAMPLES, stated.size))
    ]
    tail = (1 - CONFIDENCE) / 2
    low, high = np.quantile(drawn, [tail, 1 - tail])
    return Estimate(figure(stated, was), float(low), float(high))
