"""Calculates the weights of the mean of the heads, and of the parity that detects a wrong head.

Head i stands at the angle p_i from head 1 (docs/architecture.md, "Head geometry"): an axis that
moves by c = x + jy adds Im(c·e^{jp_i})·ρ_i/R to the head's reading. ρ_i is the disc's nominal
radius R divided by the radius of head i.

With Σwᵢ = 1 and Σwᵢ·ρᵢ·e^{jpᵢ} = 0 the mean Σwᵢrᵢ turns with the table and contains no translation
of the axis. This holds at any order, and for motion that does not repeat. Three heads have one
solution. Four heads have a family of solutions; the solution with the least noise √Σwᵢ² is taken.
Two heads have a solution at 180° only. The parity Σcᵢrᵢ with Σcᵢ = 0 and Σcᵢ·ρᵢ·e^{jpᵢ} = 0
contains neither the motion of the table nor the motion of the axis; it needs four heads.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.gateware.mean_set import WEIGHT_LIMIT, WEIGHT_ONE
from arctrue.generated.number_formats import HEADS_MAX

Float = NDArray[np.float64]

MOST_WEIGHT = WEIGHT_LIMIT / WEIGHT_ONE
"""Largest weight of the format s1.16."""
NOISE_LIMIT = 1.0
"""Largest ratio of the mean's noise to the noise of one reading; above 1, one head alone has less
noise."""
LEAK_LIMIT = 1e-3
"""Largest share of a translation that the mean may contain if no weights make it 0. Two heads stay
below this limit if they are within 6′ of 180°."""


class WeightsRefusedError(ValueError):
    """No weights exist for these places, or the gateware cannot use them."""


def translation_columns(places_rad: ArrayLike, radius_ratios: ArrayLike | None = None) -> Float:
    """Return the change of the readings by an axis motion along y and along x: ρ·cos p and ρ·sin p,
    (H, 2)."""
    places = np.asarray(places_rad, dtype=np.float64)
    ratios = np.ones_like(places) if radius_ratios is None else np.asarray(radius_ratios)
    return np.column_stack((ratios * np.cos(places), ratios * np.sin(places)))


def mean_weights(
    places_rad: ArrayLike,
    radius_ratios: ArrayLike | None = None,
    *,
    noise_limit: float = NOISE_LIMIT,
) -> Float:
    """Return the weights of the mean with the least noise, (H,).

    Raises WeightsRefusedError if no weights exclude a translation from the mean, if a weight does
    not fit into s1.16, or if the noise of the mean exceeds ``noise_limit`` times the noise of one
    reading.
    """
    places = np.asarray(places_rad, dtype=np.float64)
    conditions = np.column_stack((np.ones(places.size), translation_columns(places, radius_ratios)))
    wanted = np.array([1.0, 0.0, 0.0])
    weights = np.asarray(np.linalg.lstsq(conditions.T, wanted)[0])
    named = _degrees(places)
    if np.max(np.abs(conditions.T @ weights - wanted)) > LEAK_LIMIT:
        raise WeightsRefusedError(
            f"heads at {named}: no weights keep a motion of the axis out of the mean; two heads "
            "must stand at 180°, three or four at different places"
        )
    # If the angle between two heads differs slightly from 180°, Σw also differs from 1. The
    # division makes Σw exactly 1.
    weights = weights / weights.sum()
    largest = int(np.argmax(np.abs(weights)))
    if not -MOST_WEIGHT <= weights[largest] < MOST_WEIGHT:
        raise WeightsRefusedError(
            f"heads at {named}: the weight of the {_ordinal(largest)} is {weights[largest]:.2f}, "
            f"and the gateware holds −{MOST_WEIGHT:g} to {MOST_WEIGHT:g}; move a head"
        )
    noise = float(np.linalg.norm(weights))
    if noise > noise_limit:
        raise WeightsRefusedError(
            f"heads at {named}: the mean would have {noise:.2f} times the noise of one reading, "
            f"{noise_limit:g} is the limit; move a head"
        )
    return np.asarray(weights)


def parity_weights(places_rad: ArrayLike, radius_ratios: ArrayLike | None = None) -> Float:
    """Return the weights cᵢ of the parity of four heads, (4,), Σcᵢ² = 1; the largest one is
    positive.

    Raises WeightsRefusedError for another number of heads, or places that have more than one such
    combination.
    """
    places = np.asarray(places_rad, dtype=np.float64)
    if places.size != HEADS_MAX:
        raise WeightsRefusedError(
            f"{places.size} heads have no parity: the table's turn and the two directions of axis "
            "motion are three unknowns, so a parity needs four readings"
        )
    conditions = np.column_stack((np.ones(4), translation_columns(places, radius_ratios)))
    _, lengths, rows = np.linalg.svd(conditions.T)
    if lengths[-1] < LEAK_LIMIT:
        raise WeightsRefusedError(f"heads at {_degrees(places)}: two of them stand at one place")
    parity: Float = rows[-1]
    return np.asarray(parity * np.sign(parity[np.argmax(np.abs(parity))]))


def weights_without_each(
    places_rad: ArrayLike,
    radius_ratios: ArrayLike | None = None,
    *,
    noise_limit: float = NOISE_LIMIT,
) -> tuple[Float | WeightsRefusedError, ...]:
    """Return one entry for each head: the weights (H,) of the mean without this head, 0 for this
    head itself.

    If no weights can be used, the entry is the exception that states the reason.
    """
    places = np.asarray(places_rad, dtype=np.float64)
    ratios = np.ones_like(places) if radius_ratios is None else np.asarray(radius_ratios)
    found: list[Float | WeightsRefusedError] = []
    for missing in range(places.size):
        left = np.flatnonzero(np.arange(places.size) != missing)
        try:
            own = mean_weights(places[left], ratios[left], noise_limit=noise_limit)
        except WeightsRefusedError as error:
            found.append(error)
            continue
        weights = np.zeros(places.size)
        weights[left] = own
        found.append(weights)
    return tuple(found)


def weight_words(
    weights: ArrayLike, places_rad: ArrayLike, radius_ratios: ArrayLike | None = None
) -> NDArray[np.int32]:
    """Return weights as s1.16 words whose sum is 2¹⁶ exactly, (H,); a weight 0 stays 0.

    Among the words within 2 units of each rounded weight, the words with the smallest share of a
    translation are selected. Raises WeightsRefusedError for a weight that s1.16 does not hold, and
    for weights whose sum is not 1.
    """
    values = np.asarray(weights, dtype=np.float64) * WEIGHT_ONE
    columns = translation_columns(places_rad, radius_ratios)
    used = np.flatnonzero(values != 0.0)
    if used.size == 0:
        raise WeightsRefusedError("all weights are 0: their sum must be 1")
    nearest = np.rint(values).astype(np.int64)
    best, least = None, np.inf
    for steps in product(range(-2, 3), repeat=used.size - 1):
        words = nearest.copy()
        words[used[:-1]] += steps
        words[used[-1]] = WEIGHT_ONE - int(words[used[:-1]].sum())
        if abs(words[used[-1]] - values[used[-1]]) > 2.5:
            continue
        leak = float(np.linalg.norm(words @ columns))
        if leak < least:
            best, least = words, leak
    if best is None:
        raise WeightsRefusedError(f"the weights {list(np.asarray(weights))} do not have the sum 1")
    if np.any((best < -WEIGHT_LIMIT) | (best >= WEIGHT_LIMIT)):
        raise WeightsRefusedError(f"a weight is outside s1.16: {list(best / WEIGHT_ONE)}")
    return best.astype(np.int32)


def _degrees(places_rad: Float) -> str:
    return ", ".join(f"{place:g}°" for place in np.round(np.degrees(places_rad), 3).tolist())


def _ordinal(index: int) -> str:
    return ("first", "second", "third", "fourth")[index]


def order_factor(
    weights: ArrayLike,
    places_rad: ArrayLike,
    orders: Sequence[int] | NDArray[np.int64],
    radius_ratios: ArrayLike | None = None,
) -> NDArray[np.complex128]:
    """Return W(n) = Σwᵢ·e^{jnpᵢ}, the factor of the disc's order n in the mean, (orders,).

    At order 1 each term has the factor ρᵢ: the disc's eccentricity causes nearly all of this order,
    and its effect is inversely proportional to the head's radius.
    """
    places = np.asarray(places_rad, dtype=np.float64)
    w = np.asarray(weights, dtype=np.float64)
    at = np.asarray(orders, dtype=np.int64)
    factor = np.exp(1j * np.multiply.outer(at, places)) @ w
    if radius_ratios is not None:
        own = np.exp(1j * places) @ (w * np.asarray(radius_ratios))
        factor = np.where(at == 1, own, factor)
    return np.asarray(factor)
