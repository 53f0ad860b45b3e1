"""Computes the results of ``arctrue alpha`` as plain values."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

from arctrue.studies.head_angle.lanes_and_bits import (
    ITERATIONS,
    LANES,
    WIDTHS,
    residual_map,
    residual_of_lanes,
    rounding_arcsec,
)
from arctrue.studies.head_angle.maps import (
    PAPER_DEG,
    AlphaChoice,
    Disc,
    best_choices,
    detuned,
    judged,
    least_worst_gain,
)
from arctrue.studies.head_angle.places import Orders, as_plain

ORDERS = (10, 12, 20, 32, 40, 64)
"""Highest orders N; for each N, the result lists the best α for the orders 1 to N."""
PLACES_ORDERS = (40, 64)
"""Highest orders N; for each N, the result lists the best places of three and four heads."""


def choose_places(
    heads: int = 4,
    orders: Sequence[Orders] = PLACES_ORDERS,
    given_deg: tuple[float, ...] | None = None,
) -> dict[str, Any]:
    """Compare ``given_deg`` with the best places of the heads for each entry of ``orders``: orders
    1 to N, or a list of orders.

    Raises ValueError if the number of heads is not two to four, or differs from the number of
    places in ``given_deg``.
    """
    if given_deg is not None and len(given_deg) != heads:
        raise ValueError(f"places: expected one for each of {heads} heads, found {len(given_deg)}")
    return {"schema": 1, "places": as_plain(heads, orders, given_deg)}


def choose(alpha_deg: float = PAPER_DEG, most_orders: Sequence[int] = ORDERS) -> dict[str, Any]:
    """Compare ``alpha_deg`` with the best α for orders 1 to N, for every N of ``most_orders``."""
    disc = Disc.of_paper()
    return {
        "schema": 1,
        "alpha_deg": alpha_deg,
        "disc": {
            "orders": disc.orders.tolist(),
            "amplitude_arcsec": disc.amplitude_arcsec.tolist(),
        },
        "choices": [
            {
                "most_order": most,
                "least_worst_gain": least_worst_gain(most),
                "given": _plain(judged(alpha_deg, most, disc)),
                "best": [_plain(one) for one in best_choices(most, disc)[:3]],
            }
            for most in most_orders
        ],
        "lanes": [
            {"lanes": lanes, "residual_arcsec": residual_of_lanes(disc, lanes)} for lanes in LANES
        ],
        "bits": {
            "widths": list(WIDTHS),
            "iterations": list(ITERATIONS),
            "residual_arcsec": residual_map(disc).tolist(),
        },
        "rounding_arcsec": rounding_arcsec(),
    }


def _plain(one: AlphaChoice) -> dict[str, Any]:
    return dataclasses.asdict(one) | {
        "total_arcsec": one.total_arcsec,
        "worst_gain_within_tolerance": detuned(one.alpha_deg, one.most_order),
    }
