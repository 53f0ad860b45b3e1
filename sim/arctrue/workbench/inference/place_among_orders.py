"""Finds the error of a single station if the orders of the model fit the errors of all stations.

The residual then does not show this error, because the error of one station is also a sum of all
orders. A curve of few orders and one station has fewer coefficients than the model.
"""

from __future__ import annotations

import numpy as np

from arctrue.workbench.inference.repeated_error import RepeatedError, Spot
from arctrue.workbench.inference.same_place import (
    FAMILY_WISE,
    LEAST_OWN,
    LEAST_REPEATED,
    NEARLY_ALL,
    STEP_AHEAD,
    SURE_P,
    Visits,
)
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.inference.visits_of_places import visits_beyond_low_orders


def place_among_orders(solution: Solution) -> RepeatedError | None:
    """Return the single station that differs from a curve of low orders in every pass.

    None if there is no such station, or if the residual of the model shows the errors of the
    stations.
    """
    rows = solution.observations.reference
    if rows is None or solution.observations.capture is not None or len(solution.terms) != 1:
        return None
    if "reference" in solution.unknown_noise:
        return None
    orders = len(solution.terms[0].effect.disc_orders(solution.terms[0].nonlinear))
    found = visits_beyond_low_orders(rows, orders, solution.noise.reference)
    return None if found is None else _one_place(*found)


def _one_place(visits: Visits, low: int) -> RepeatedError | None:
    """Return the place that explains nearly the whole error beyond the orders 1 to ``low``, and
    explains it better than any single higher order; None if there is no such place.

    By chance, a sum of orders of random sizes also has the share NEARLY_ALL at one place: the
    orders 8 to 12 at 24 stations in one of 1,500 sets (24 times the p of a squared correlation of
    0.9 in nine dimensions).
    """
    test, places = visits.by_place, visits.angle_rad.size
    if test.p >= SURE_P or test.rms_arcsec <= LEAST_REPEATED * test.scatter_arcsec:
        return None
    normal, moment, count = visits.system
    own = np.diag(normal)
    free = own > LEAST_OWN * count
    gain = np.where(free, moment**2 / np.where(free, own, 1.0), 0.0)
    best = int(np.argmax(gain))
    most = float(gain[best])
    if test.upper_p_of_size(float(np.sqrt(most / test.within))) > FAMILY_WISE / places:
        return None
    of_order = 0.0
    for order in range(low + 1, places // 2 + 1):
        phase = order * visits.angle_rad
        wave = np.stack([np.cos(phase), np.sin(phase)], axis=1)
        sizes = np.linalg.lstsq(wave.T @ normal @ wave, wave.T @ moment, rcond=1e-9)[0]
        of_order = max(of_order, float(sizes @ (wave.T @ moment)))
    excess = float(np.sum(moment**2 / count)) - test.between_freedom * test.within
    if most < NEARLY_ALL * excess or most - of_order < STEP_AHEAD * test.within:
        return None
    spot = Spot(
        float(np.degrees(visits.angle_rad[best])),
        float(moment[best] / own[best]),
        float(np.sqrt(test.within / own[best])),
        0.0,
    )
    passes = visits.visits_of_a_place
    return RepeatedError(test.rms_arcsec, passes, places, (spot,), beyond_order=low)
