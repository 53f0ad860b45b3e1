"""Finds errors of the reference that follow a form of a recorded condition c.

A form is a function of the difference from a value c₀ (square, magnitude, part above or part below
c₀), or the condition after a first-order lag. Slow noise that is estimated while the effect is not
in the model absorbs such a slow error. Therefore only the white part of the noise is used to
compare the forms. The likelihood ratio with newly estimated noise decides whether a form is stated.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.first_order_lag import both_ways
from arctrue.workbench.effects.part_conditions import (
    FORMS,
    LAG,
    SEARCHED_FORMS,
    TEMPERATURE,
    TEMPERATURE_COLUMN,
    Condition,
    column_of,
    form_condition,
    recorded_conditions,
)
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.inference.likelihood_ratio import without_slow_noise
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.maximum import highest
from arctrue.workbench.observations import Observations, ReferenceRows

Float = NDArray[np.float64]

PLACES = (0.15, 0.35, 0.5, 0.65, 0.85)
"""Quantiles of a condition that are tried as c₀. In the plane that c and c² span, the vector
(c − c₀)² turns by equal angles from one quantile to the next if c has a normal distribution; with
c₀ beyond the outer quantiles, it is nearly a straight line in c."""
LAGS = 8
"""Number of lags that are tried, in equal ratios."""
SHORTEST_STEPS, LONGEST_SPANS = 2.0, 0.25
"""Shortest lag, in median steps of the rows: a shorter lag only smooths the noise of the column.
Longest lag, in lengths of the record: with a longer lag, the unknown condition before the first row
changes most rows."""
AHEAD = 0.5
"""Smallest gain of a form whose c₀ or lag is refined, as a share of the largest gain. If the
condition is a sine and the true c₀ of a parabola lies between two PLACES, the parabola at one of
these two has at least 0.65 of the full gain."""
ROUNDS = 8
"""Largest number of steps in the search of c₀ or a lag, to limit cost."""
LEAST_LEVELS = 4
"""Fewest different values of a condition: a form with a free c₀ fits any three levels."""
MOST_ROWS = 20_000
"""Largest number of rows of the reference, to limit cost."""
OF_TIME = 3
"""Degree of the polynomial of the time that must explain less than the form. If the condition only
rises and falls once, its forms resemble such a polynomial, and so does any drift."""


@dataclass(frozen=True)
class FoundForm:
    """The best form of all conditions, and the number of forms that were tried."""

    effect: ProductOfParts
    gain: float
    rank: int
    trials: float


def is_searched_form(effect: object) -> bool:
    """Tell whether an effect is a form that this search finds; a form of a user's column with
    c₀ = 0 belongs to the other products of parts."""
    if not isinstance(effect, ProductOfParts) or effect.orders or effect.frame != "reference":
        return False
    condition = effect.condition
    own = condition.form in FORMS and condition.column != TEMPERATURE_COLUMN
    return bool(condition.form) and not (own and condition.column_zero == 0.0)


def follows_a_record(effect: object) -> bool:
    """Tell whether an effect is a recorded condition or a form of it, without an order."""
    if not isinstance(effect, ProductOfParts) or effect.orders:
        return False
    return effect.condition is TEMPERATURE or effect.condition.column is not None


def straight(effect: ProductOfParts, observations: Observations) -> ProductOfParts:
    """Return the product with the recorded condition itself in place of its form."""
    column = effect.condition.column
    found = (item for item in recorded_conditions(observations) if item.column == column)
    return _product(TEMPERATURE if column == TEMPERATURE_COLUMN else next(found))


def columns_with_forms(observations: Observations) -> list[str]:
    """Return the recorded conditions of the reference that may have a form."""
    rows = observations.reference
    if rows is None or rows.run.size > MOST_ROWS:
        return []
    found = []
    for name in (TEMPERATURE_COLUMN, *rows.conditions):
        values = column_of(rows, name)
        if values is None or not np.all(np.isfinite(values)):
            continue
        if np.unique(values).size >= LEAST_LEVELS:
            found.append(name)
    return found


def best_form(residuals: Residuals) -> FoundForm | None:
    """Return the form with the largest gain in white noise.

    None if this form does not explain more than the condition itself, the condition after symmetric
    smoothing (for a lag), and a polynomial of the time.
    """
    rows = residuals.observations.reference
    names = columns_with_forms(residuals.observations)
    if rows is None or not names:
        return None
    white = without_slow_noise(residuals)
    tried = [item for name in names for item in _tried(rows, name)]
    scores = white.scores([(_product(condition), {}) for condition, _ in tried])
    gains = [score.gain for score in scores]
    if max(gains) <= 0.0:
        return None
    found = [
        _product(_refined(white, tried, number))
        for number in _first_of_each([item for item, _ in tried], gains)
    ]
    refined = white.scores([(item, {}) for item in found])
    best = int(np.argmax([score.gain for score in refined]))
    effect, score = found[best], refined[best]
    least = white.score(straight(effect, residuals.observations), {}).gain
    if effect.condition.form == LAG:
        least = max(least, _smoothed(white, rows, effect, [place for _, place in tried]))
    least = max(least, _curve_of_time(white, rows))
    if score.rank == 0 or score.gain <= least:
        return None
    return FoundForm(effect, score.gain, score.rank, float(len(tried)))


def _product(condition: Condition) -> ProductOfParts:
    return ProductOfParts.of(condition, (), "reference")


def _tried(rows: ReferenceRows, column: str) -> Iterator[tuple[Condition, float]]:
    """Return the forms of a column, each with its c₀ or lag."""
    values = column_of(rows, column)
    assert values is not None
    for form in SEARCHED_FORMS:
        for place in np.quantile(values, PLACES).tolist():
            yield form_condition(column, form, _rounded(place)), place
    time_s = rows.time_s
    if time_s is None or not np.all(np.diff(time_s) > 0.0):
        return
    shortest = SHORTEST_STEPS * float(np.median(np.diff(time_s)))
    longest = LONGEST_SPANS * float(np.ptp(time_s))
    if longest > 2.0 * shortest:
        middle = _rounded(float(np.median(values)))
        for lag_s in np.geomspace(shortest, longest, LAGS).tolist():
            yield form_condition(column, LAG, middle, _rounded(lag_s)), lag_s


def _rounded(value: float) -> float:
    """Return a value as the description states it."""
    return float(f"{value:.4g}")


def _first_of_each(tried: Sequence[Condition], gains: Sequence[float]) -> list[int]:
    """Return, for each form of each column, the number of the trial with the largest gain, if this
    gain is near the largest of all.

    All these forms are refined, because PLACES are so far apart that a wrong form may have the
    largest gain before that.
    """
    first: dict[tuple[str | None, str], int] = {}
    for number in np.argsort(gains)[::-1].tolist():
        first.setdefault((tried[number].column, tried[number].form), number)
    return [number for number in first.values() if gains[number] > AHEAD * max(gains)]


def _refined(white: Residuals, tried: Sequence[tuple[Condition, float]], number: int) -> Condition:
    """Return the form with the c₀ or lag of the largest gain between its neighbours."""
    condition, place = tried[number]
    near = [
        tried[other][1]
        for other in (number - 1, number + 1)
        if 0 <= other < len(tried)
        and (tried[other][0].form, tried[other][0].column) == (condition.form, condition.column)
    ]
    column, form = condition.column or "", condition.form

    def at(place: float) -> Condition:
        if form == LAG:
            return form_condition(column, LAG, condition.column_zero, _rounded(np.exp(place)))
        return form_condition(column, form, _rounded(place))

    def gain(place: float) -> float:
        return white.score(_product(at(place)), {}).gain

    if form == LAG:
        place, near = float(np.log(place)), [float(np.log(lag_s)) for lag_s in near]
    low, high = min([place, *near]), max([place, *near])
    best, top = highest(gain, low, high, ROUNDS)
    return at(best) if top > gain(place) else condition


def _smoothed(
    white: Residuals, rows: ReferenceRows, effect: ProductOfParts, lags_s: Sequence[float]
) -> float:
    """Return the largest gain of the condition after symmetric smoothing. Any smoothing removes the
    noise of a recorded column; a lag must therefore explain more than symmetric smoothing."""
    values, time_s = column_of(rows, effect.condition.column or ""), rows.time_s
    assert values is not None
    assert time_s is not None
    gains = []
    for lag_s in [*np.geomspace(min(lags_s[-LAGS:]), max(lags_s[-LAGS:]), LAGS)]:
        smooth = both_ways(values, time_s, float(lag_s))
        gains.append(white.score(_of_values(smooth), {}).gain)
    return max(gains)


def _curve_of_time(white: Residuals, rows: ReferenceRows) -> float:
    """Return the gain of a polynomial of the time of degree OF_TIME."""
    if rows.time_s is None:
        return 0.0
    along = 2.0 * (rows.time_s - rows.time_s.min()) / max(float(np.ptp(rows.time_s)), 1e-300) - 1.0
    total, base = 0.0, white
    for power in range(1, OF_TIME + 1):
        effect = _of_values(along**power)
        score = base.score(effect, {})
        if score.rank == 0:
            break
        total += score.gain
        base = Residuals(base.solution_with(effect, {}, score))
    return total


def _of_values(values: Float) -> ProductOfParts:
    """Return a product whose condition has these values in the rows of the reference."""

    def of(rows: object) -> Float | None:
        return values if isinstance(rows, ReferenceRows) else None

    product = _product(TEMPERATURE)
    product.condition = Condition("curve", "curve", "", of)
    return product
