"""A fitted model as coefficients of the gateware, and what of it lanes cannot correct."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from arctrue.calibration.harmonics import as_function_of_reading
from arctrue.gateware.coefficients import ORDER_MAX, Coefficients
from arctrue.units import arcsec_per_count
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.model.model import Model
from arctrue.workbench.observations import Observations

LOW_ORDERS = 200
"""Up to here an order of the true angle and of the reading differ: above, the reading is used.

Signal-period orders are functions of the reading from the start: they live in the counts.
"""


@dataclass(frozen=True)
class Export:
    """Coefficients, and in words what stays uncorrected."""

    coefficients: Coefficients
    orders: list[int]
    amplitudes_arcsec: list[float]
    left_out: list[str]


def export_model(
    model: Model,
    observations: Observations,
    effects: Mapping[str, type[Effect]],
    *,
    lanes: int,
    temperature_c: float | None,
) -> Export:
    """Quantise a fitted model for the gateware.

    Raises ValueError for a model without coefficients, or more harmonics than lanes.
    """
    if observations.counts_per_rev is None:
        raise ValueError("the gateware counts: table.counts_per_rev is missing in the set")
    by_order: dict[int, np.ndarray[tuple[int], np.dtype[np.float64]]] = {}
    left_out: list[str] = []
    for entry in model.effects:
        effect = entry.effect(effects)
        if effect.compensation != "lanes":
            note = effect.compensation_note or "lanes cannot correct it"
            left_out.append(f"{entry.name}: {note}")
            continue
        if not entry.coefficients:
            raise ValueError(f"{entry.name}: has no coefficients; fit the model first")
        for lane in effect.lanes(
            np.array(entry.coefficients), entry.search, observations, temperature_c
        ):
            if lane.order > ORDER_MAX:
                left_out.append(f"{entry.name}: order {lane.order} is above {ORDER_MAX}")
                continue
            pair = np.array([lane.cosine_arcsec, lane.sine_arcsec])
            by_order[lane.order] = by_order.get(lane.order, np.zeros(2)) + pair
    low = sorted(order for order in by_order if order <= LOW_ORDERS)
    if low:
        values = np.array([by_order[order] for order in low]).T.ravel()
        read = as_function_of_reading(np.array(low, dtype=np.int64), values).reshape(2, -1).T
        for order, pair in zip(low, read, strict=True):
            by_order[order] = pair
    orders = sorted(by_order, key=lambda order: -float(np.hypot(*by_order[order])))
    count = arcsec_per_count(observations.counts_per_rev)
    kept = orders[:lanes]
    for order in orders[lanes:]:
        size = float(np.hypot(*by_order[order]))
        left_out.append(f"order {order} ({size:.3f}″): no lane left, {lanes} are there")
    kept.sort()
    amplitudes = [float(np.hypot(*by_order[order])) for order in kept]
    phases = [float(np.arctan2(-by_order[order][1], by_order[order][0])) for order in kept]
    coefficients = Coefficients.from_harmonics(
        kept, np.array(amplitudes) / count, phases, observations.counts_per_rev, lanes
    )
    return Export(coefficients, kept, amplitudes, left_out)
