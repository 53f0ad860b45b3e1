"""Moves a place to the maximum of its gain between the grid points of a scan."""

from __future__ import annotations

from collections.abc import Callable

from scipy.optimize import minimize_scalar

from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.places import Place, gain_of_its_own

MOST_MOVES = 4
"""Largest number of steps of a search before it encloses the maximum."""
EDGE_STEPS = 5
"""Number of bisection steps near a place where the gain is set to 0: five steps reach a thirtieth
of the grid step, which is exact enough."""
PARABOLAS = 3
"""Largest number of parabolas, each through the three best places so far."""
SAME_PLACE = 2e-3
"""Share of the distance between the outer two of three places; if the maximum moves by less, it
counts as found."""


def moved_to_maximum(
    effect: Effect, residuals: Residuals, found: list[Place], name: str, step: float
) -> list[Place]:
    """Move the best place to its maximum between the grid points.

    The model has absorbed a part of the line. Next to one of the model's orders, this part is most
    of the line, so that the maximum of the remaining gain may be more than a step away. The search
    therefore moves on while one side is higher than the centre.
    """
    if not found:
        return found
    first = found[0]
    low, high = effect.search_range(name)

    def allowed(place: float) -> bool:
        return low <= place <= high

    def gain(place: float) -> float:
        if not allowed(place):
            return 0.0
        score = residuals.score(effect, {**first.nonlinear, name: float(place)})
        return gain_of_its_own(effect, score)

    centre, top = first.nonlinear[name], first.gain
    for _ in range(MOST_MOVES):
        sides = [centre - step, centre + step]
        residuals.scores(
            [(effect, {**first.nonlinear, name: side}) for side in sides if allowed(side)]
        )
        heights = [gain(side) for side in sides]
        if max(heights) == top:
            break
        if max(heights) < top:
            if min(heights) == 0.0:
                # The gain may rise towards a place that the model explains completely, up to the
                # place where it is set to 0.
                cut_off = sides[heights.index(0.0)]
                edge = _at_the_edge(gain, centre, top, cut_off)
                if edge[1] > top:
                    centre, top = edge
                    break
            places = [sides[0], centre, sides[1]]
            centre, top = _top_of_three(gain, places, [heights[0], top, heights[1]])
            break
        top = max(heights)
        centre = sides[heights.index(top)]
    best = Place({**first.nonlinear, name: centre}, top, first.trials)
    return [best, *found[1:]]


def _at_the_edge(
    gain: Callable[[float], float], centre: float, top: float, cut_off: float
) -> tuple[float, float]:
    """Return the place nearest to ``cut_off`` up to which the gain rises, and the gain there; at
    ``cut_off`` the gain is 0."""
    for _ in range(EDGE_STEPS):
        tried = 0.5 * (centre + cut_off)
        height = gain(tried)
        if height > top:
            centre, top = tried, height
        elif height > 0.0:
            break
        else:
            cut_off = tried
    return centre, top


def _top_of_three(
    gain: Callable[[float], float], places: list[float], heights: list[float]
) -> tuple[float, float]:
    """Return place and height of the maximum that three places enclose, by parabolas."""
    for _ in range(PARABOLAS):
        (low, middle, high), (left, top, right) = places, heights
        below, above = (middle - low) * (top - right), (middle - high) * (top - left)
        change = 0.5 * ((middle - low) * below - (middle - high) * above) / (below - above)
        tried = middle - change
        if abs(change) < SAME_PLACE * (high - low):
            break
        places, heights = sorted([*places, tried]), [*heights, gain(tried)]
        heights.insert(places.index(tried), heights.pop())
        best = min(max(heights.index(max(heights)), 1), 2)
        places, heights = places[best - 1 : best + 2], heights[best - 1 : best + 2]
    return places[1], heights[1]


def highest(
    gain: Callable[[float], float], low: float, high: float, evaluations: int
) -> tuple[float, float]:
    """Return place and height of the maximum between two places (Brent's method)."""
    found = minimize_scalar(
        lambda place: -gain(float(place)),
        bounds=(low, high),
        method="bounded",
        options={"maxiter": evaluations, "xatol": 1e-4 * (high - low)},
    )
    return float(found.x), -float(found.fun)
