"""Finds orders that the samples of a capture, or the stations of a reference, cannot
distinguish."""

from __future__ import annotations

import numpy as np

from arctrue.workbench.diagnose.candidate import Candidate, is_line
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.disc import ALIAS_AHEAD, DISC_BINS, samples_a_turn
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.one_speed import speed_turns_s
from arctrue.workbench.observations.rows import ReferenceRows
from arctrue.workbench.observations.stations_a_turn import STATION_DECIMALS

UNEVEN = 1e-3
"""Largest relative difference between the distances of neighbouring stations that count as even.
With 360 stations, this difference changes the phase of the 360th order by 0.4° from one station to
the next, which is so little that orders and their aliases look equal."""
HIGHEST_ORDER = DISC_BINS / 8.0
"""Highest order of an alias that is tested and listed for the samples of a capture."""

MOST_FOLDED = 8.0
"""Largest number of rows per period of a line at which the periods of its aliases are stated. With
more rows, the slowest alias has nearly one row per period: a reference that averages over its step
would show only 0.14 of its amplitude (sinc 7/8)."""


def above_half_the_samples(item: Candidate, residuals: Residuals) -> bool:
    """Tell whether a searched disc order has fewer than two samples of the capture per period."""
    if item.effect.search_kind != "disc_order" or residuals.observations.capture is None:
        return False
    return item.nonlinear["order"] > samples_a_turn(residuals) / 2.0


def aliases(item: Candidate, observations: Observations) -> list[float]:
    """Return orders that the rows cannot distinguish from the order of an effect, the lowest
    first."""
    if not in_capture(item, observations):
        return _of_stations(item, observations)
    return _of_samples(item)


def in_capture(item: Candidate, observations: Observations) -> bool:
    """Tell whether the effect has columns in R₂ − R₁."""
    capture = observations.capture
    if capture is None:
        return False
    few, context = capture.part(slice(0, 8)).of_head(2), item.solution.context
    return item.effect.capture_columns(few, item.nonlinear, context) is not None


def _of_samples(item: Candidate) -> list[float]:
    """Return the orders N ± ν, with N samples per turn, that explain all rows as well as the order
    ν.

    Each order is scored on all rows. Runs that start at different angles or have different numbers
    of samples per turn can exclude an alias; a reference can exclude it too. The list is empty if
    ``item.evidence`` is None.
    """
    order = item.nonlinear.get("order", 0.0)
    if order <= 0.0 or item.evidence is None:
        return []
    base = item.evidence.base
    a_turn = samples_a_turn(base)
    own = base.score(item.effect, item.nonlinear).gain
    whole = bool(item.effect.disc_orders(item.nonlinear))
    found = []
    for one in (abs(a_turn - order), a_turn + order):
        alias = float(round(one)) if whole else one
        low, high = item.effect.search_range("order")
        if not max(low, 1.0) <= alias <= min(high, HIGHEST_ORDER) or abs(alias - order) < 1.0:
            continue
        if own - base.score(item.effect, {**item.nonlinear, "order": alias}).gain < ALIAS_AHEAD:
            found.append(round(alias, 6))
    return sorted(found)


def _of_stations(item: Candidate, observations: Observations) -> list[float]:
    """Return the lowest aliases k·N ± n of an order n at N even stations, at most four.

    The list is empty if n is N/2 or less, or if the stations are uneven.
    """
    rows = observations.reference
    order = item.effect.declared_order(observations)
    stated = item.parameters().get("order")
    order = stated.value if stated is not None else order
    if rows is None or order is None:
        return []
    place = np.unique(np.round(np.mod(rows.target_rad, 2.0 * np.pi), STATION_DECIMALS))
    gaps = np.diff(place, append=place[0] + 2.0 * np.pi)
    stations = place.size
    if np.ptp(gaps) > UNEVEN * float(gaps.mean()) or order <= stations / 2.0:
        return []
    low = float(order % stations)
    others = {low, stations - low, stations + low, 2.0 * stations - low}
    return sorted(round(one, 6) for one in others if one > 0.0 and abs(one - order) > UNEVEN)


def folded_periods_s(item: Candidate, observations: Observations) -> tuple[float, list[float]]:
    """Return the step of a reference with even steps of time, and the periods of the two slowest
    lines that look like the line ``item`` at these rows; no periods if the line has at most 2 or at
    least MOST_FOLDED rows per period.

    At the step h, the frequencies 1/h − f and 1/h + f look like f.
    """
    rows = observations.reference
    nonlinear = item.nonlinear
    if rows is None or rows.time_s is None or nonlinear.get("in_capture") or not is_line(item):
        return 0.0, []
    frequency = nonlinear.get("frequency", 0.0)
    if not nonlinear.get("in_time"):
        order = nonlinear.get("order", 0.0)
        speed = speed_turns_s(rows, order) if order > 0.0 else None
        frequency = 0.0 if speed is None else order * abs(speed)
    step, periods_s = folded_frequencies(rows, frequency)
    return (step, []) if frequency * step * MOST_FOLDED <= 1.0 else (step, periods_s)


def folded_frequencies(rows: ReferenceRows, frequency: float) -> tuple[float, list[float]]:
    """Return the step of rows with even steps of time, and the periods of the two slowest lines
    that look like a frequency; no periods if the steps are uneven."""
    if rows.time_s is None:
        return 0.0, []
    steps = np.diff(rows.time_s)[np.diff(rows.run) == 0]
    if steps.size == 0 or frequency <= 0.0:
        return 0.0, []
    step = float(np.median(steps))
    if step <= 0.0 or float(np.max(np.abs(steps / step - np.round(steps / step)))) > UNEVEN:
        return 0.0, []
    if frequency * step >= 0.5:
        return step, []
    return step, [1.0 / (1.0 / step - frequency), 1.0 / (1.0 / step + frequency)]
