"""Applies the rule of thumb: the order or frequency of the residual's most significant line names
the effect."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from arctrue.studies.benchmark.peers.textbook import BASE_ORDERS, Fit, Float, Problem, problem

FALSE_ALARM = 0.01
"""Largest false-alarm probability of a line that names an effect; chosen."""
HIGHEST_ORDER = 400
"""Highest order that the search tries, if the rows are dense enough; chosen."""


def periodogram_rule(folder: Path) -> dict[str, Any]:
    """Name the effect of the line (a sine in angle or time) with the smallest false-alarm
    probability if this is at most 1 %, otherwise answer ``adequate``; without a capture, answer
    ``cannot_tell``."""
    fit = Fit(problem(folder))
    given, left = fit.given, fit.left()[fit.part(0)]
    if not left.size:
        return {"verdict": "cannot_tell", "named": None, "class": [], "further": []}
    turn_rows = 2 * np.pi / max(float(np.median(np.abs(np.diff(given.theta)))), 1e-9)
    highest = min(HIGHEST_ORDER, turn_rows / 2.0 - BASE_ORDERS)
    order, by_angle = _in_angle(given.theta, left, np.arange(0.5, highest, 0.5))
    by_time = _in_time(given, left)
    if min(by_angle, by_time) > np.log(FALSE_ALARM):
        return {"verdict": "adequate", "named": None, "class": [], "further": []}
    if by_time < by_angle:
        name = "vibration"
    elif order != round(order):
        name = "bearing_ball_pass"
    else:
        name = "radial_error_motion" if order <= BASE_ORDERS else "high_order_graduation"
    return {"verdict": "named", "named": name, "class": [name], "further": []}


def _in_angle(angle: Float, left: Float, orders: Float) -> tuple[float, float]:
    """Return the order of the strongest line in angle, and the logarithm of its false-alarm
    probability; the probability is 1 if the rows are too sparse for two orders."""
    if orders.size < 2:
        return 0.0, 0.0
    values = left - left.mean()
    turned = values * np.exp(-1j * orders[0] * angle)
    step = np.exp(-1j * (orders[1] - orders[0]) * angle)
    power = np.empty(orders.size)
    for at in range(orders.size):
        power[at] = abs(turned.sum()) ** 2 / values.size
        turned *= step
    return float(orders[power.argmax()]), _chance(float(power.max()), values, orders.size)


def _in_time(given: Problem, left: Float) -> float:
    """Return the logarithm of the smallest false-alarm probability of the strongest lines of all
    runs."""
    best = 0.0
    for number in given.runs:
        values = left[given.run == number]
        if values.size < 2:
            continue
        values = values - values.mean()
        power = np.abs(np.fft.rfft(values)[1:]) ** 2 / values.size
        best = min(best, _chance(float(power.max()), values, power.size * given.runs.size))
    return best


def _chance(power: float, values: Float, places: int) -> float:
    """Return the logarithm of the probability that white noise has a line of at least this power at
    one or more of ``places`` orders or frequencies.

    The probability p at one place is exp(−power/σ²), and the result is 1 − (1 − p)^places. For a
    very small p the result is places·p, computed as a logarithm so that it does not underflow.
    """
    ratio = max(power / max(float(values.var()), 1e-30), 1e-12)
    if ratio > 30.0:
        return float(np.log(places) - ratio)
    return float(np.log(-np.expm1(places * np.log1p(-np.exp(-ratio)))))
