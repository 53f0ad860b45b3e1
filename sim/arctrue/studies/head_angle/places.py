"""Searches for the best places of three and four heads: places with little noise in each order (low
gains) at which the mean stays usable if any one head is missing.

Three heads determine the disc's error if the axis does not move; four heads determine the disc's
error by a parity relation even if the axis moves at every order. The search minimises the largest
gain of orders 1 to N, or of listed orders. The search permits only places at which the mean has at
most NOISE_LIMIT times the noise of one head; with four heads this must also hold if any one head is
missing. The mean does not contain order 1 of the disc, so that with four heads order 1 does not
count. Two heads have no mean; for them the search varies only the place of the second head.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.calibration.head_weights import (
    WeightsRefusedError,
    mean_weights,
    order_factor,
    weights_without_each,
)
from arctrue.calibration.heads_gain import MotionOrders, order_gain

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

LEAST_DEG = 20.0
"""Smallest angle between two read heads of the paper's size, degrees."""
STEP_DEG = 4.0
"""Step of the first search over all places; later steps, which move the heads of the best sets, are
smaller."""
BEST = 100
"""Number of sets of places from the first search that are improved by smaller steps."""
LISTED = 10
"""Number of different sets of places that the search returns."""
MOVES_DEG = (1.5, 0.8, 0.4, 0.2, 0.1)
STEP_OF_TWO_DEG = 0.1
"""Step of the search for the place of the second of two heads."""
STARTS_DEG = {3: (), 4: ((0.0, 64.3, 177.0, 257.9),)}
"""Known good places; the search with smaller steps also starts from these places."""
NOISE_LIMIT = 0.85
"""Largest permitted noise of the mean of three heads (of any three of four heads), in units of the
noise of one head; STARTS_DEG has 0.82."""
_BLOCK = 4096
Orders = int | tuple[int, ...]
"""Orders of the disc that count; a number N means the orders 1 to N."""


@dataclass(frozen=True)
class PlacesChoice:
    """Properties of one set of places; ``most_order`` is the highest order that counts."""

    places_deg: tuple[float, ...]
    most_order: int
    motion: MotionOrders
    worst_gain: float
    worst_order: int
    gain: tuple[float, ...]
    """Noise of each order from 1 on, in units of the noise of one head."""
    mean_gain: tuple[float, ...]
    """Gain of each order in the mean: the noise that the order's lane adds."""
    mean_noise: float
    """Noise of one reading of the mean, in units of the noise of one head; inf if no mean
    exists."""
    noise_without: tuple[float, ...]
    """Noise of the mean without each single head; inf if no mean exists."""


def motion_of(heads: int) -> MotionOrders:
    """Return the orders at which the axis may move: every order with four heads, else none."""
    return "every" if heads == 4 else ()


def judged_places(places_deg: tuple[float, ...], asked: Orders) -> PlacesChoice:
    """Compute the properties of a given set of two to four places."""
    places = np.radians(places_deg)
    counted = _counted(len(places_deg), asked)
    most_order = int(counted[-1])
    motion = motion_of(len(places_deg))
    orders = np.arange(1, most_order + 1)
    gain = order_gain(places, orders, motion)
    worst = int(counted[np.argmax(gain[counted - 1])])
    weights = _noise(places)
    without = tuple(
        np.inf if isinstance(one, WeightsRefusedError) else float(np.linalg.norm(one))
        for one in weights_without_each(places, noise_limit=np.inf)
    )
    return PlacesChoice(
        places_deg,
        most_order,
        motion,
        float(gain[worst - 1]),
        worst,
        tuple(gain.tolist()),
        () if weights is None else _seen_by_mean(gain, weights, places, orders),
        np.inf if weights is None else float(np.linalg.norm(weights)),
        without,
    )


def _seen_by_mean(gain: Float, weights: Float, places: Float, orders: Integer) -> tuple[float, ...]:
    factor = np.abs(order_factor(weights, places, orders))
    # The mean never contains order 1, so order 1 does not count.
    return tuple(np.where(factor < 1e-9, 0.0, gain * factor).tolist())


def best_places(heads: int, asked: Orders) -> list[PlacesChoice]:
    """List the best ``LISTED`` sets of places, best first; sets that are equal up to rotation and
    mirroring appear once.

    Raises ValueError if there are not two to four heads, or if no places of the search keep the
    noise of the mean below ``NOISE_LIMIT``.
    """
    if heads not in (2, 3, 4):
        raise ValueError(f"heads: expected 2 to 4, found {heads}")
    if heads == 2:
        second = np.arange(LEAST_DEG, 180.0 + STEP_OF_TWO_DEG / 2.0, STEP_OF_TWO_DEG)
        pairs = np.column_stack((np.zeros(second.size), second))
        return _judged_best(pairs, _worst_gain(pairs, asked), asked)
    grid = np.arange(STEP_DEG, 360.0, STEP_DEG)
    sets = np.array([(0.0, *rest) for rest in combinations(grid.tolist(), heads - 1)])
    sets = sets[_allowed(sets)]
    if sets.size == 0:
        raise ValueError(f"no places of {heads} heads have a mean below {NOISE_LIMIT:g}")
    worst = _worst_gain(sets, asked)
    best = sets[np.argsort(worst, kind="stable")[:BEST]]
    best = np.array([*best.tolist(), *STARTS_DEG[heads]])
    for step in MOVES_DEG:
        best = _moved(best, step, asked)
    best = best[_allowed(best)]
    return _judged_best(best, _worst_gain(best, asked), asked)


def _judged_best(sets_deg: Float, worst: Float, asked: Orders) -> list[PlacesChoice]:
    """Return the best ``LISTED`` different sets of places, best first; ``worst`` is the largest
    gain of each set."""
    found: list[PlacesChoice] = []
    for index in np.argsort(worst, kind="stable"):
        if len(found) == LISTED:
            break
        places = tuple(np.round(sets_deg[index], 1).tolist())
        if all(_unlike(places, one.places_deg) for one in found):
            found.append(judged_places(places, asked))
    # The rounding of the places changes their gains, so the sets are sorted again.
    return sorted(found, key=lambda one: one.worst_gain)


def as_plain(heads: int, asked: Sequence[Orders], given_deg: tuple[float, ...] | None) -> Any:
    """Return ``given_deg`` and the three best places for each of the ``asked`` orders; ``orders``
    is the list of the orders that count, if a list was asked for."""
    return [
        {
            "heads": heads,
            "most_order": one if isinstance(one, int) else max(one),
            **({} if isinstance(one, int) else {"orders": _counted(heads, one).tolist()}),
            "given": None if given_deg is None else asdict(judged_places(given_deg, one)),
            "best": [asdict(best) for best in best_places(heads, one)[:3]],
        }
        for one in asked
    ]


def _counted(heads: int, asked: Orders) -> Integer:
    orders = np.arange(1, asked + 1) if isinstance(asked, int) else np.unique(asked)
    counted = orders[orders > 1] if heads == 4 else orders
    if counted.size == 0:
        raise ValueError("orders: the mean of four heads does not contain order 1; list others too")
    return np.asarray(counted, dtype=np.int64)


def _worst_gain(sets_deg: Float, asked: Orders) -> Float:
    heads = sets_deg.shape[1]
    orders = _counted(heads, asked)
    worst = [
        order_gain(np.radians(sets_deg[start : start + _BLOCK]), orders, motion_of(heads)).max(-1)
        for start in range(0, len(sets_deg), _BLOCK)
    ]
    return np.concatenate(worst)


def _allowed(sets_deg: Float) -> NDArray[np.bool_]:
    """Tell which sets are permitted: enough room between heads, and noise of the mean within the
    limit; with four heads also if any one is missing."""
    turned = np.sort(np.mod(sets_deg, 360.0), axis=1)
    apart = np.diff(np.column_stack((turned, turned[:, :1] + 360.0)), axis=1)
    room = apart.min(axis=1) >= LEAST_DEG
    places, heads = np.radians(sets_deg), sets_deg.shape[1]
    triples = [list(one) for one in combinations(range(heads), 3)]
    noise = np.max([_noise_of_three(places[:, triple]) for triple in triples], axis=0)
    # The mean of four heads has no more noise than the mean of any three of the heads.
    return np.asarray(room & (noise <= NOISE_LIMIT))


def _noise_of_three(places_rad: Float) -> Float:
    """Return the noise √Σw² of the mean of three heads, (sets,); w₁ ∝ sin(p₃ − p₂), others
    cyclically."""
    first, second, third = places_rad.T
    shares = np.sin(np.stack((third - second, first - third, second - first)))
    total = shares.sum(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        noise = np.linalg.norm(shares, axis=0) / np.abs(total)
    return np.where(np.abs(total) > 1e-9, noise, np.inf)


def _moved(sets_deg: Float, step_deg: float, asked: Orders) -> Float:
    """Move heads of each set by steps as long as a step lowers the set's largest gain, at most six
    times."""
    heads = sets_deg.shape[1]
    moves = np.array(np.meshgrid(*[(-1.0, 0.0, 1.0)] * (heads - 1))).reshape(heads - 1, -1).T
    moves = np.column_stack((np.zeros(len(moves)), moves)) * step_deg
    best = sets_deg.copy()
    for _ in range(6):
        tried = (best[:, None, :] + moves[None, :, :]).reshape(-1, heads)
        worst = np.where(_allowed(tried), _worst_gain(tried, asked), np.inf).reshape(len(best), -1)
        chosen = np.argmin(worst, axis=1)
        # A set without a better permitted move keeps its places, so every set stays permitted.
        moved = best + moves[chosen]
        if np.array_equal(moved, best):
            break
        best = moved
    return best


def _noise(places: Float) -> Float | None:
    try:
        return mean_weights(places, noise_limit=np.inf)
    except WeightsRefusedError:
        return None


def _unlike(one: tuple[float, ...], other: tuple[float, ...]) -> bool:
    """Tell whether two sets of places differ by more than about 1° for every choice of the first
    head and of the positive direction."""
    return not any(
        np.allclose(_steps(other), np.roll(way, shift), atol=1.0)
        for way in (_steps(one), _steps(one)[::-1])
        for shift in range(len(one))
    )


def _steps(places_deg: tuple[float, ...]) -> Float:
    turned = np.sort(np.mod(places_deg, 360.0))
    return np.diff(np.append(turned, turned[0] + 360.0))
