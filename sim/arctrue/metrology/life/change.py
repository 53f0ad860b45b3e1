"""Finds changes of a series: steps and the beginnings of drifts, with a stated false-alarm rate.

The statistic is the generalised likelihood ratio: the largest value of N·log(RSS₀/RSS₁) over all
steps between two sets and all drifts that begin at a set. RSS₀ is the weighted sum of squares about
a constant, RSS₁ about a constant plus this step or drift; N is the number of values. The weight of
a set is 1/(u² + s²); u comes from its fit, and s is the scatter between sets by Paule and Mandel
(1982).

The null distribution is computed from the statistic of normal random numbers with these weights. A
common factor of the variance cancels, so the true scatter need not be known. The p-value of a
series is its rank among these draws; multiplied by the number of series (Bonferroni) it bounds the
probability of any false alarm in one evaluation of the whole machine. If the sum of the exact tail
probabilities over all tried changes (Boole's inequality) is below 1/(draws + 1), the p-value is
this sum instead. For one change, 1 − RSS₁/RSS₀ has the distribution Beta(d/2, d·(n − 2)/2), with n
sets of d components.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import betainc

from arctrue.metrology.life.series import Series

Float = NDArray[np.float64]
Kind = Literal["step", "drift"]
Shape = tuple[Kind, int, float]
"""Kind, place and exponent that define a change."""
Random = np.random.Generator

FEWEST_SETS = 7
"""Smallest number of sets: two on either side of a change, and three degrees of freedom for the
scatter."""
ON_A_SIDE = 2
"""Smallest number of sets on each side of a step, and after the beginning of a drift; a single
outlying set is therefore not a change."""
MOST_CHANGES = 4
"""Largest number of changes that the search finds in one series."""
FEWEST_DRAWS, MOST_DRAWS = 199, 19_999
DRAWS_OF_ALPHA = 10.0
"""The number of draws for each series is this value times the number of series, divided by α. It is
limited to FEWEST_DRAWS and MOST_DRAWS. The smallest adjusted rank is then a tenth of α, or more
with MOST_DRAWS."""
EXPONENTS = (0.5, 1.0, 2.0)
"""Exponents of the time since a drift began: with 0.5 the drift slows down, with 1 it keeps its
rate, with 2 it speeds up. The search for changes uses 1; date, size and forecast are averaged over
all three."""
LEVEL = 0.95
"""Probability that the stated interval of dates contains the true date."""
DAYS_A_YEAR = 365.25
LARGEST_ALPHA = 0.05
"""Upper limit of the false-alarm probability of one evaluation; it applies if there are few sets a
year."""
BISECTIONS = 40
"""Number of bisections in the search for the square of the scatter; the last interval is 10⁻¹² of
the first one."""


@dataclass(frozen=True, eq=False)
class Place:
    """One kind of change at one place, with its posterior probability."""

    kind: Kind
    index: int
    """Index of the first set after a step, or of the last set before a drift."""
    probability: float
    exponent: float = 1.0
    """Exponent of the time since a drift began."""

    @property
    def shape(self) -> Shape:
        """Kind, place and exponent in the form that :func:`basis` takes."""
        return self.kind, self.index, self.exponent


@dataclass(frozen=True, eq=False)
class Change:
    """One change of a series."""

    series: Series
    kind: Kind
    earliest_day: float
    day: float
    """Most probable day: the middle between the sets before and after a step, or the middle of the
    time in which a drift begins."""
    latest_day: float
    p_value: float
    """Probability that at least one series of an unchanged machine shows a change of this size in
    one evaluation."""
    size: float
    """Size of the change up to the last set, in the unit of the series."""
    u: float
    """Standard uncertainty of ``size``."""
    places: tuple[Place, ...]


def basis(days: Float, kind: Kind, index: int, exponent: float = 1.0) -> Float:
    """Return the shape of a change, (sets,): it is 0 before the change and 1 at the last set."""
    if kind == "step":
        return (np.arange(days.size) >= index).astype(np.float64)
    begin = days[index]
    return np.asarray((np.maximum(days - begin, 0.0) / (days[-1] - begin)) ** exponent)


def places(days: Float) -> list[tuple[Kind, int]]:
    """Return kind and place of every change that the search tries, (kind, index).

    A drift needs a later date at which the value has changed: among sets of the same date only the
    last one is a beginning.
    """
    sets = days.size
    steps: list[tuple[Kind, int]] = [
        ("step", index) for index in range(ON_A_SIDE, sets - ON_A_SIDE + 1)
    ]
    begins = (index for index in range(sets - ON_A_SIDE) if days[index + 1] > days[index])
    return [*steps, *(("drift", index) for index in begins)]


def weights(values: Float, u: Float, design: Float) -> Float:
    """Return the weights 1/(u² + s²), (sets,).

    Paule and Mandel's scatter s makes the weighted sum of squared residuals equal to its degrees of
    freedom. ``values`` (sets, components); ``design`` (sets, columns) is the design matrix of the
    model that gives the residuals.
    """
    freedom = int((values.shape[0] - design.shape[1]) * values.shape[1])
    if freedom <= 0:
        return np.asarray(1.0 / u**2)

    def excess(square: float) -> float:
        weight: Float = 1.0 / (u**2 + square)
        return weighted_rss(values, weight, design) - freedom

    if excess(0.0) <= 0.0:
        return np.asarray(1.0 / u**2)
    low, high = 0.0, max(float(np.var(values, axis=0).sum()), float(u.min()) ** 2)
    while excess(high) > 0.0:
        high *= 4.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) > 0.0 else (low, middle)
    return np.asarray(1.0 / (u**2 + high))


def weighted_rss(values: Float, weight: Float, design: Float) -> float:
    """Return the weighted sum of squared residuals of a fit with the design matrix ``design``, over
    all components."""
    root = np.sqrt(weight)[:, None]
    solution, *_ = np.linalg.lstsq(root * design, root * values, rcond=None)
    return float(np.sum((root * (values - design @ solution)) ** 2))


def ratios(days: Float, weight: Float, values: Float) -> Float:
    """Return the largest likelihood ratio of each row of values, (rows,).

    ``weight`` (rows, sets) or (1, sets), ``values`` (rows, sets, components); ``days`` (sets,). A
    change reduces RSS₀ by (Σw·h·r)²/(Σw·h² − (Σw·h)²/Σw), where r are the residuals about the mean.
    """
    total = weight.sum(axis=1)
    mean = np.einsum("kn,knd->kd", weight, values) / total[:, None]
    residual = values - mean[:, None, :]
    weighted = weight[:, :, None] * residual
    rss = np.einsum("knd,knd->k", weighted, residual)
    shapes = np.stack([basis(days, *place) for place in places(days)])
    across = np.einsum("knd,mn->kmd", weighted, shapes, optimize=True)
    norm = weight @ (shapes**2).T - (weight @ shapes.T) ** 2 / total[:, None]
    taken = np.sum(across**2, axis=2) / np.maximum(norm, np.finfo(float).tiny)
    left = np.maximum(1.0 - taken.max(axis=1) / np.maximum(rss, np.finfo(float).tiny), 1e-12)
    return np.asarray(-values.shape[2] * days.size * np.log(left))


def look_probability(days: Float, false_alarms_a_year: float) -> float:
    """Return the false-alarm probability permitted for one evaluation, if the machine is evaluated
    after every set. Sets of the same date count as one evaluation."""
    dates = np.unique(days)
    between = float(np.median(np.diff(dates))) if dates.size > 1 else DAYS_A_YEAR
    return float(min(false_alarms_a_year * between / DAYS_A_YEAR, LARGEST_ALPHA))


def largest_tail(ratio: float, days: Float, components: int) -> float:
    """Return an upper limit of the probability that an unchanged series has a likelihood ratio of
    at least ``ratio``: the sum of the probabilities of all changes that are tried."""
    sets = days.size
    one_change = betainc(
        0.5 * components * (sets - 2), 0.5 * components, np.exp(-ratio / (components * sets))
    )
    return float(len(places(days)) * one_change)


def adjusted_p_values(
    series: Sequence[Series], values: Sequence[Float], alpha: float, random: Random
) -> Float:
    """Return for each series the probability that any series of an unchanged machine shows a change
    as large as the series' own.

    ``values``: (sets, components) of each series, minus the known changes.
    """
    wanted = DRAWS_OF_ALPHA * len(series) / max(alpha, 1e-9)
    number = int(np.clip(wanted, FEWEST_DRAWS, MOST_DRAWS))
    found = np.empty(len(series))
    for place, (one, own) in enumerate(zip(series, values, strict=True)):
        weight = weights(own, one.u, np.ones((one.days.size, 1)))[None]
        measured = float(ratios(one.days, weight, own[None])[0])
        found[place] = largest_tail(measured, one.days, own.shape[1])
        if found[place] < 1.0 / (number + 1.0):
            continue
        normal = random.standard_normal((number, *own.shape)) / np.sqrt(weight)[:, :, None]
        null = ratios(one.days, weight, normal)
        found[place] = (1.0 + np.count_nonzero(null >= measured)) / (number + 1.0)
    return np.minimum(found * len(series), 1.0)


def find_changes(
    series: Sequence[Series], false_alarms_a_year: float, random: Random
) -> list[Change]:
    """Find the changes of all series, in the order in which they are found; return none for fewer
    than ``FEWEST_SETS`` sets.

    All series have the same days. After each found change, the function subtracts this change and
    tests the series again, at most ``MOST_CHANGES`` times.
    """
    if not series or series[0].days.size < FEWEST_SETS:
        return []
    alpha = look_probability(series[0].days, false_alarms_a_year)
    values = [one.values for one in series]
    known: list[list[Shape]] = [[] for _ in series]
    found: list[Change] = []
    open_ = list(range(len(series)))
    for _ in range(MOST_CHANGES):
        p_values = adjusted_p_values(
            [series[i] for i in open_], [values[i] for i in open_], alpha, random
        )
        changed = [(i, float(p)) for i, p in zip(open_, p_values, strict=True) if p <= alpha]
        for i, p_value in changed:
            change = _located(series[i], known[i], p_value)
            likeliest = max(change.places, key=lambda place: place.probability)
            known[i].append(likeliest.shape)
            found.append(change)
            values[i] = series[i].values - _of_changes(series[i], known[i])
        open_ = [i for i, _ in changed]
        if not open_:
            break
    return found


def design_of(days: Float, known: Sequence[Shape]) -> Float:
    """Return the design matrix of a constant and the known changes, (sets, 1 + changes)."""
    return np.stack([np.ones(days.size), *(basis(days, *place) for place in known)], axis=1)


def _of_changes(series: Series, known: Sequence[Shape]) -> Float:
    """Return the sum of the known changes with their fitted sizes, (sets, components)."""
    design = design_of(series.days, known)
    root = np.sqrt(weights(series.values, series.u, design))[:, None]
    solution, *_ = np.linalg.lstsq(root * design, root * series.values, rcond=None)
    return np.asarray(design[:, 1:] @ solution[1:])


def _located(series: Series, known: Sequence[Shape], p_value: float) -> Change:
    """Return kind, date and size of the most probable further change, given the ``known``
    changes."""
    probable = posterior(series, known)
    best = max(probable, key=lambda place: place.probability)
    days = series.days
    design = design_of(days, [*known, best.shape])
    weight = weights(series.values, series.u, design)
    root = np.sqrt(weight)[:, None]
    solution, *_ = np.linalg.lstsq(root * design, root * series.values, rcond=None)
    covariance = np.linalg.pinv((root * design).T @ (root * design))
    begin, end = np.array([_between(days, place) for place in probable]).T
    share = np.array([place.probability for place in probable])
    order = np.argsort(begin)
    earliest = begin[order][np.searchsorted(np.cumsum(share[order]), 0.5 * (1.0 - LEVEL))]
    order = np.argsort(-end)
    latest = end[order][np.searchsorted(np.cumsum(share[order]), 0.5 * (1.0 - LEVEL))]
    low, high = _between(days, best)
    return Change(
        series,
        best.kind,
        float(earliest),
        0.5 * (low + high),
        float(latest),
        p_value,
        float(np.linalg.norm(solution[-1])),
        float(np.sqrt(covariance[-1, -1])),
        tuple(probable),
    )


def _between(days: Float, place: Place) -> tuple[float, float]:
    """Return the two days between which a change of this kind and place lies."""
    if place.kind == "step":
        return float(days[place.index - 1]), float(days[place.index])
    earlier = days[days < days[place.index]]
    return float(earlier[-1] if earlier.size else days[0]), float(days[place.index + 1])


def posterior(series: Series, known: Sequence[Shape]) -> list[Place]:
    """Return the probability of every kind and place of a further change, with equal prior
    probabilities.

    Coefficients and variance are integrated out under Jeffreys' prior: the integrated likelihood is
    |X'WX|^(−d/2) · RSS^(−(n − p)·d/2). All shapes reach 1 at the last set; the prior of the whole
    change is therefore the same for a step and a drift.
    """
    days, values = series.days, series.values
    size, parts = values.shape
    used = {shape[:2] for shape in known}
    tried: list[Shape] = [
        (kind, index, exponent)
        for kind, index in places(days)
        if (kind, index) not in used
        for exponent in (EXPONENTS if kind == "drift" else (1.0,))
    ]
    logs = np.empty(len(tried))
    designs = [design_of(days, [*known, place]) for place in tried]
    weight = weights(values, series.u, np.ones((size, 1)))
    best = min(designs, key=lambda design: weighted_rss(values, weight, design))
    weight = weights(values, series.u, best)
    for number, design in enumerate(designs):
        scaled = np.sqrt(weight)[:, None] * design
        sign, determinant = np.linalg.slogdet(scaled.T @ scaled)
        # A drift up to the last date equals a step before that date.
        if sign <= 0 or np.linalg.matrix_rank(scaled) < scaled.shape[1]:
            logs[number] = -np.inf
            continue
        freedom = (size - design.shape[1]) * parts
        rss = max(weighted_rss(values, weight, design), np.finfo(float).tiny)
        logs[number] = -0.5 * parts * determinant - 0.5 * freedom * np.log(rss)
    share = np.exp(logs - logs.max())
    share /= share.sum()
    return [
        Place(kind, index, float(value), exponent)
        for (kind, index, exponent), value in zip(tried, share, strict=True)
    ]
