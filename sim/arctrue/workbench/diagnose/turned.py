"""Finds errors that turn with a part that was mounted again: the solution of a multi-step test.

If a gauge, a polygon or an indexing table is turned between the runs by a recorded angle m, the
error is f(target) + g(target + m): f belongs to the table, g to the part that was turned. The model
describes f; a product of parts with the orders of g describes g.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.observations import Observations, ReferenceRows
from arctrue.workbench.observations.column_unit import column_unit
from arctrue.workbench.observations.different_stations import stations_of
from arctrue.workbench.observations.polygon_faces import FACE_TOLERANCE_DEG, keep_to_faces

LEAST_STATIONS, MOST_ORDERS = 3, 30
"""Fewest stations of a turn, and highest order of g, which is that of the other products of
parts."""
LEAST_TURNED = 0.1
"""Smallest share of the variance of a wave of g that waves of f cannot reproduce, 1 − |mean of
exp(i n m)|²; Marquardt calls a variance inflation factor of 10 too large (Technometrics 12 (1970)
610)."""


def turned_products(observations: Observations) -> list[ProductOfParts]:
    """Return, for each column by which a part was turned between the runs, and for both signs of
    it, one product for each order of g and one for all orders together."""
    rows = observations.reference
    if rows is None:
        return []
    target_deg = np.degrees(rows.target_rad)
    stations = rows.faces or stations_of(target_deg)
    if stations < LEAST_STATIONS or 360.0 / stations <= 2.0 * FACE_TOLERANCE_DEG:
        # Rows of a log on the move are so close to each other that any column seems to step by
        # whole stations.
        return []
    if not keep_to_faces(stations, rows.run, target_deg):
        return []
    found = []
    for name, column in rows.conditions.items():
        if column_unit(name) != "deg" or not _turns(rows, column, 360.0 / stations):
            continue
        highest = min(stations // 2, MOST_ORDERS)
        orders = [
            float(order)
            for order in range(1, highest + 1)
            if 1.0 - np.abs(np.mean(np.exp(1j * order * np.radians(column)))) ** 2 > LEAST_TURNED
        ]
        waves = [[order] for order in orders] + ([orders] if len(orders) > 1 else [])
        found += [
            ProductOfParts(orders=wave, fixed_to="reference", turned_by=sign + name)
            for sign in ("", "-")
            for wave in waves
        ]
    return found


def _turns(rows: ReferenceRows, column: NDArray[np.float64], pitch_deg: float) -> bool:
    """Tell whether a column is constant in each run and steps by whole stations between runs."""
    first = np.unique(rows.run, return_index=True)[1]
    of_run = column[first[np.searchsorted(rows.run[first], rows.run)]]
    steps = (column - column[0]) / pitch_deg
    away_deg = np.abs(steps - np.round(steps)) * pitch_deg
    return bool(
        np.all(np.abs(column - of_run) <= FACE_TOLERANCE_DEG)
        and np.all(away_deg <= FACE_TOLERANCE_DEG)
        and np.ptp(np.mod(np.round(steps), 360.0 / pitch_deg)) > 0.0
    )
