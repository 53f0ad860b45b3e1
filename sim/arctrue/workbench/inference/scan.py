"""Scans for the search parameters of an effect that fit the residuals of a model best.

A *place* is a set of values of the search parameters. A scan for orders, frequencies or bumps
processes the rows once: it bins C⁻¹·residual, transforms it by FFT, divides the power by the
information about a wave in this noise, and finds the maxima. A scan for steps uses cumulative sums.
The best places are then scored exactly, with the model projected out; a scan over a grid scores
every point. ``trials`` is the number of independent places.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len
from scipy.optimize import minimize_scalar
from scipy.special import log_ndtr, ndtr

from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.channels import (
    best_factor,
    channel_rows,
    power_of_channels,
    shifts_of_channels,
)
from arctrue.workbench.inference.residuals import Residuals, Score
from arctrue.workbench.noise.row_noise import RowNoise
from arctrue.workbench.observations import ReferenceRows

Float = NDArray[np.float64]

LONGEST_WINDOW = 1 << 19
"""Largest number of samples in one transform over time; padded with zeros, the transform has four
times as many samples, 16 MB."""
BEST_PLACES = 4
"""Number of places of a coarse scan that are scored exactly."""
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
DISC_BINS = 1 << 15
"""Number of bins in a turn. With eight bins per period, the highest order that is searched is
4,096, a quarter of the lines of the paper's disc."""
SEPARATING_GAIN = 30.0
"""Amount by which the gain of an order must exceed the gain of the nearest whole or half order. For
one more parameter p is then 4·10⁻⁸, and 5·10⁻⁶ for all 120 gaps up to order 60 together."""
IN_A_GAP = np.array([-1.2, -0.9, -0.6, -0.3, 0.3, 0.6, 0.9, 1.2])
"""Offsets at which orders near a whole or half order are scored, in the gap around it and next to
this gap, in units of the resolution 1/(2·turns). With T turns, neighbouring offsets differ by at
most 0.3/T, and the peak of a line in one run extends 0.5/T to either side, so that two neighbouring
offsets cannot both miss it.
"""
LINES = frozenset({"frequency", "line", "unwrapped_order"})
"""Kinds of search for a wave of any order or frequency, not only of whole orders."""
LEAST_OWN = 0.05
"""Smallest share of a line's weighted squares that the model of whole orders must leave. In one run
of T turns this share is 1 − sinc²(δT), where δ is the distance from a whole order, so that a line
is found only at a distance of 1/(8T) or more.
"""
BLIND_FACTOR = 0.02
"""If |e^{jnα} − 1| is below this value, two heads cannot show order n."""
ALIAS_AHEAD = 6.0
"""Gain by which an order above half the samples per turn must exceed the best lower order: odds of
20 to 1, "strong" on the scale of Kass and Raftery, J. Am. Stat. Assoc. 90 (1995) 773."""
STATION_DECIMALS = 6
"""Number of decimals of a radian to which stations are rounded; stations with equal rounded angles
count as one."""
LARGEST_GAP_STEPS = 8.0
"""A reference run covers a whole turn if its largest gap is shorter than this number of its median
steps."""


@dataclass(frozen=True, slots=True)
class Place:
    """Search parameters that were found, and the number of independent places that were tried."""

    nonlinear: dict[str, float]
    gain: float
    """Weighted sum of squares that the columns remove from the residuals, 2·Δ(log likelihood)."""
    trials: float


def scored(
    effect: Effect, residuals: Residuals, places: Iterable[dict[str, float]], trials: float
) -> list[Place]:
    """Return the exact gain of each place within the declared ranges, best first."""
    ranges = {item.name: effect.search_range(item.name) for item in effect.search}
    tried = [
        place
        for place in places
        if all(ranges[name][0] <= value <= ranges[name][1] for name, value in place.items())
    ]
    scores = residuals.scores([(effect, place) for place in tried])
    found = [
        Place(place, _gain_of_its_own(effect, score), max(trials, 1.0))
        for place, score in zip(tried, scores, strict=True)
    ]
    return sorted(found, key=lambda candidate: -candidate.gain)


def _gain_of_its_own(effect: Effect, score: Score) -> float:
    """Return the gain, or 0 for a line that the model explains almost completely.

    Next to one of the model's own orders, such a line describes a slow change of this order, and
    its size has no meaning.
    """
    return score.gain if effect.search_kind not in LINES or score.own_share > LEAST_OWN else 0.0


def peaks(power: Float, count: int) -> NDArray[np.int64]:
    """Return the indices of the highest local maxima, highest first."""
    if power.size == 0:
        return np.zeros(0, dtype=np.int64)
    padded = np.concatenate([[-np.inf], power, [-np.inf]])
    top = (padded[1:-1] >= padded[:-2]) & (padded[1:-1] >= padded[2:])
    places = np.flatnonzero(top)
    return places[np.argsort(power[places])[::-1][:count]]


def disc_spectra(residuals: Residuals, bins: int) -> list[NDArray[np.complex128]]:
    """Return Σ (C⁻¹r)·e^{−jnθ} over the capture rows of each channel, n = 0 … bins/2."""
    capture, precise = residuals.observations.capture, residuals.capture_precise
    assert capture is not None
    assert precise is not None
    place = np.floor(capture.line1_rad * (bins / (2.0 * np.pi))).astype(np.int64) % bins
    return [
        np.asarray(np.fft.rfft(np.bincount(place[rows], weights=precise[rows], minlength=bins)))
        for rows in channel_rows(capture)
    ]


def order_information(residuals: Residuals, orders: Float) -> Float:
    """Return the information of the capture rows about e^{jνθ}: the sum over the rows of
    1/(spectral density of the noise at ν·ω)."""
    noise, rows = residuals.solution.noise.capture, residuals.observations.capture
    assert noise is not None
    assert rows is not None
    total = np.full(orders.size, 1e-30)
    for part, spectrum in zip(noise.stretches, noise.spectra, strict=True):
        count = part.stop - part.start
        step = noise.step(part)
        way = np.abs(np.diff(rows.angle_rad[part]))
        turns_a_step = float(np.median(way)) / (2.0 * np.pi) if count > 1 else 0.0
        density = spectrum.density(orders * (turns_a_step / max(step, 1e-300)), step)
        total += count / (density * noise.mean_square_scale(part))
    return np.asarray(total)


def samples_a_turn(residuals: Residuals) -> float:
    """Return the number of capture samples in a turn, calculated from the median step."""
    capture = residuals.observations.capture
    assert capture is not None
    steps = np.abs(np.diff(capture.angle_rad))
    inside = np.diff(capture.run) == 0
    if not inside.any():
        return 0.0
    return float(2.0 * np.pi / max(float(np.median(steps[inside])), 1e-12))


def disc_order_scan(effect: Effect, residuals: Residuals) -> list[Place]:
    """Search whole orders of the disc in the declared range; return the best places, best first.

    Orders whose alias is below the range are omitted.

    With N samples per turn, orders n and N − n differ only by a phase in each run. Runs that start
    at different angles separate the two; for a single run, the lower order is preferred.
    """
    low, high = effect.search_range("order")
    above = int(low) - 1
    capture = residuals.observations.capture
    if capture is None:
        return []
    a_turn = samples_a_turn(residuals)
    highest = int(min(a_turn - low if a_turn > 2.0 * low else 0.0, DISC_BINS / 8.0, high))
    if highest <= above:
        return []
    orders = np.arange(highest + 1)
    power = power_of_channels(disc_spectra(residuals, DISC_BINS))[: highest + 1]
    power /= order_information(residuals, orders.astype(np.float64))
    blind = best_factor(capture, orders) < BLIND_FACTOR
    power[blind | (orders <= above)] = 0.0
    best = np.argsort(power)[::-1][:BEST_PLACES]
    aliases = np.abs(np.round(a_turn) - best)
    tried = np.unique(np.concatenate([best, aliases[aliases <= highest].astype(np.int64)]))
    found = scored(
        effect, residuals, ({"order": float(order)} for order in tried), float(highest - above)
    )
    if not found or found[0].nonlinear["order"] <= a_turn / 2.0:
        return found
    below = next((item for item in found if item.nonlinear["order"] <= a_turn / 2.0), None)
    if below is None or found[0].gain - below.gain > ALIAS_AHEAD:
        return found
    return [below, *(item for item in found if item is not below)]


def stations_a_turn(rows: ReferenceRows) -> float:
    """Return the number of reference stations in a turn, calculated from the median step.

    The result is 0 if the stations do not cover the whole turn.
    """
    # The gap from the last station to the first counts too: on an arc this gap is many steps long.
    place = np.unique(np.round(np.mod(rows.target_rad, 2.0 * np.pi), STATION_DECIMALS))
    steps = np.abs(np.diff(rows.target_rad))[np.diff(rows.run) == 0]
    moved = steps[steps > 10.0**-STATION_DECIMALS]
    if place.size < 3 or moved.size == 0:
        return 0.0
    step = float(np.median(moved))
    widest = float(np.diff(place, append=place[0] + 2.0 * np.pi).max())
    return 2.0 * np.pi / step if widest < LARGEST_GAP_STEPS * step else 0.0


def unwrapped_order_scan(effect: Effect, residuals: Residuals) -> list[Place]:
    """Search orders that are not whole, over the unwrapped angle of all revolutions together."""
    lowest, highest = effect.search_range("order")
    capture, precise = residuals.observations.capture, residuals.capture_precise
    if capture is None or precise is None:
        return []
    bins_a_turn = 8 * int(np.ceil(highest))
    place = np.floor(capture.angle_rad * (bins_a_turn / (2.0 * np.pi))).astype(np.int64)
    place -= place.min()
    length = int(place.max()) + 1
    if length > 1 << 24:
        # Runs that are tens of thousands of turns apart are not searched, because their relative
        # phase is unknown.
        return []
    padded = 1 << int(np.ceil(np.log2(4 * length)))
    power = power_of_channels(
        [
            np.fft.rfft(np.bincount(place[rows], weights=precise[rows], minlength=length), padded)
            for rows in channel_rows(capture)
        ]
    )
    orders: Float = np.arange(power.size).astype(np.float64) * (bins_a_turn / padded)
    power, orders = power[orders <= highest], orders[orders <= highest]
    power /= order_information(residuals, orders)
    turns = length / bins_a_turn
    resolution = residuals.observations.order_resolution
    power[(orders > highest) | (orders < max(resolution, lowest))] = 0.0
    trials, step = 2.0 * turns * highest, 0.25 / turns
    away = _away_from_halves(orders)
    # A gap is the interval around a whole or half order that the turns do not resolve. Next to a
    # gap, the highest point may be the edge of the gap, which is no local maximum.
    coarse = [
        {"order": float(orders[index])}
        for index in peaks(np.where(away < resolution, 0.0, power), BEST_PLACES)
    ]
    found = scored(effect, residuals, coarse, trials)
    refined = moved_to_maximum(effect, residuals, found, "order", step)
    if refined and _away_from_halves(refined[0].nonlinear["order"]) < resolution:
        # A place that has moved into a gap may be the whole or half order itself, so that it is not
        # used.
        refined = found
    inside = _inside_a_gap(effect, residuals, power, orders, trials, step)
    return inside if inside and (not refined or inside[0].gain > refined[0].gain) else refined


def _away_from_halves(orders: Float | float) -> Float:
    """Return the distance of each order from the nearest whole or half order."""
    twice = np.multiply(orders, 2.0)
    return np.asarray(np.abs(twice - np.round(twice)) / 2.0)


def _inside_a_gap(
    effect: Effect, residuals: Residuals, power: Float, orders: Float, trials: float, step: float
) -> list[Place]:
    """Return the best order within a gap, if it differs significantly from the whole or half order.

    A gap is the interval around a whole or half order that the turns do not resolve.

    Two lines are resolved at 1/(2·turns). The higher a single line is above the noise, the more
    exactly its place is known (Rife and Boorstyn, IEEE Trans. Inf. Theory 20 (1974) 591): a line
    has an order of its own if its gain exceeds the gain at the whole or half order by
    SEPARATING_GAIN.
    """
    resolution = residuals.observations.order_resolution
    near = _away_from_halves(orders) < resolution
    inside = orders[peaks(np.where(near, power, 0.0), BEST_PLACES)]
    # The model has absorbed most of a line next to one of its own orders. The highest remaining
    # power may be outside the gap, or at an order that the model explains nearly completely.
    outside = orders[peaks(np.where(near, 0.0, power), 1)]
    gaps = np.unique(np.round(2.0 * np.concatenate([inside[:1], outside])) / 2.0)
    grid = (gaps[:, np.newaxis] + resolution * IN_A_GAP).ravel()
    coarse = [{"order": float(order)} for order in np.concatenate([inside, grid])]
    found = moved_to_maximum(
        effect,
        residuals,
        scored(effect, residuals, coarse, trials),
        "order",
        min(step, 0.5 * resolution),
    )
    if not found:
        return []
    order = found[0].nonlinear["order"]
    half = {"order": round(2.0 * order) / 2.0}
    known_information = found[0].gain - residuals.score(effect, half).gain > SEPARATING_GAIN
    return found if known_information and order != half["order"] else []


def frequency_scan(effect: Effect, residuals: Residuals) -> list[Place]:
    """Search frequencies in time. Each run has its own phase, so that the powers of the runs are
    added."""
    capture, precise = residuals.observations.capture, residuals.capture_precise
    noise = residuals.solution.noise.capture
    if capture is None or precise is None or noise is None:
        return []
    parts = noise.stretches
    longest = residuals.observations.longest_run_s
    if longest <= 0.0:
        return []
    spans = [
        (part, spectrum)
        for part, spectrum in zip(parts, noise.spectra, strict=True)
        if part.stop - part.start >= 16
    ]
    periods = [noise.step(part) for part, _ in spans]
    shortest = min((period for period in periods if period > 0.0), default=0.0)
    if shortest <= 0.0:
        return []
    # A long run is cut into windows, and the powers of the windows are added like the powers of the
    # runs.
    window_s = min(longest, LONGEST_WINDOW * shortest) * (1.0 + 1e-9)
    spacing = 0.25 / min(longest, window_s)
    total = np.zeros(0)
    bandwidths = 0.0
    for (part, spectrum), period in zip(spans, periods, strict=True):
        if period <= 0.0:
            continue
        start, end = part.start, part.stop
        since = capture.time_s[start:end] - capture.time_s[start]
        cuts = np.searchsorted(since, np.arange(1, int(since[-1] / window_s) + 1) * window_s)
        for first, last in pairwise([0, *cuts.tolist(), since.size]):
            if last - first >= 16:
                power = _window_power(
                    since[first:last], precise[start + first : start + last], period, spacing
                )
                grid = np.arange(power.size).astype(np.float64) * spacing
                density = spectrum.density(grid, period)
                power *= density * noise.mean_square_scale(part)
                if power.size > total.size:
                    total = np.concatenate([total, np.zeros(power.size - total.size)])
                total[: power.size] += power
        bandwidths = max(bandwidths, 0.5 / period)
    low, high = effect.search_range("frequency")
    tried = np.arange(total.size) * spacing
    total[(tried < low) | (tried > high)] = 0.0
    coarse = [{"frequency": float(index * spacing)} for index in peaks(total, BEST_PLACES)]
    trials = bandwidths * longest
    fine = 0.25 / longest
    if fine > 0.9 * spacing:
        return moved_to_maximum(
            effect, residuals, scored(effect, residuals, coarse, trials), "frequency", spacing
        )
    # The whole run resolves frequencies that lie between the frequencies of a window.
    places = [
        {"frequency": float(frequency)}
        for place in coarse[:2]
        for frequency in place["frequency"] + np.arange(-spacing, spacing, 2.0 * fine)
    ]
    return moved_to_maximum(
        effect, residuals, scored(effect, residuals, places, trials), "frequency", fine
    )


def _window_power(since_s: Float, precise: Float, period: float, spacing: float) -> Float:
    """Return the power of one window at the multiples of ``spacing``; zero below the frequencies
    that it can resolve."""
    place = np.round((since_s - since_s[0]) / period).astype(np.int64)
    values = np.bincount(place, weights=precise)
    # The length has small prime factors only, because other lengths take several times as long.
    size = next_fast_len(max(int(np.ceil(1.0 / (spacing * period))), values.size), real=True)
    power = np.abs(np.fft.rfft(values, size)) ** 2 * (2.0 / since_s.size)
    grid = np.arange(int(0.5 / (period * spacing)) + 1) * spacing
    power = np.interp(grid, np.arange(power.size) / (size * period), power)
    lowest = int(np.ceil(2.0 / (float(since_s[-1] - since_s[0]) * spacing)))
    power[:lowest] = 0.0
    return np.asarray(power)


def moved_to_maximum(
    effect: Effect, residuals: Residuals, found: list[Place], name: str, step: float
) -> list[Place]:
    """Move the best place to its maximum between the grid points.

    The model has absorbed its part of the line. Next to one of the model's orders this is most of
    the line, so that the remaining maximum may be more than a step away. The search therefore moves
    on while one side is higher than the centre.
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
        return _gain_of_its_own(effect, score)

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


LEAST_STEP_ROWS = 4
"""Smallest number of rows of the run on either side of a step: one more than the largest number of
consecutive wrong rows."""
LEAST_LEAD = 10.0
"""Smallest difference of the gains at which a step that stays in the later runs replaces one that
ends with its run; a difference of ten (odds of 150 to 1) is strong evidence."""
STEP_PLACES = 24
"""Number of places in a run at which the information about a step is computed; between these places
the information changes slowly and is interpolated."""


def step_trials(gain: float, rows: int) -> float:
    """Return the number of independent instants of a step among ``rows`` rows.

    This number grows with the gain, because a larger gain has a sharper maximum in time. The
    probability that white noise gives a gain of b² anywhere is b·φ(b)·Σ ν(b·√r)·r over the instants
    k, r = n/(k(n − k)) (James, James and Siegmund, Biometrika 74 (1987) 71; ν as Siegmund and
    Yakir, The Statistics of Gene Mapping, 2007, approximate it). Here this probability is divided
    by the probability at one instant, 2·Φ(−b). Below b = 1, where the formula does not hold, b = 1
    is used.
    """
    if rows < 2 * LEAST_STEP_ROWS:
        return 0.0
    size = float(np.sqrt(max(gain, 1.0)))
    before = np.arange(LEAST_STEP_ROWS, rows - LEAST_STEP_ROWS + 1).astype(np.float64)
    rate = rows / (before * (rows - before))
    half = 0.5 * size * np.sqrt(rate)
    share = (ndtr(half) - 0.5) / (half * (half * ndtr(half) + _normal_density(half)))
    log_once = float(np.log(2.0) + log_ndtr(-size))
    log_any = -0.5 * size**2 - 0.5 * float(np.log(2.0 * np.pi)) + float(np.log(size))
    return float(np.exp(log_any - log_once) * np.sum(rate * share))


def _normal_density(value: Float) -> Float:
    return np.asarray(np.exp(-0.5 * value**2) / np.sqrt(2.0 * np.pi))


def step_scan(effect: Effect, residuals: Residuals) -> list[Place]:
    """Search the instant after which a run's residual is higher or lower, by cumulative sums.

    If the effect has the setting ``stays``, the instant after which a run and all later runs are
    higher or lower is searched too. The number of trials includes both forms and, with several
    channels, steps of head 1.
    """
    capture, precise = residuals.observations.capture, residuals.capture_precise
    noise = residuals.solution.noise.capture
    if capture is None or precise is None or noise is None:
        return []
    places: list[tuple[float, dict[str, float]]] = []
    sizes: list[int] = []
    known_information = 1.0 / residuals.solution.noise.index_variance
    # Moment and information of a constant in the later runs of the same channel.
    later: dict[int, tuple[float, float]] = {}
    staying: list[tuple[float, dict[str, float]]] = []
    for part in reversed(noise.stretches):
        size = part.stop - part.start
        if size < 2 * LEAST_STEP_ROWS:
            continue
        moment = np.cumsum(precise[part][::-1])[::-1][1:]
        alone = RowNoise(
            noise.clock[part], np.zeros(1, dtype=np.int64),
            (noise.spectra[noise.stretches.index(part)],), noise.scale[part],
        )  # fmt: skip
        edge = np.unique(np.geomspace(1, size / 2, STEP_PLACES // 2).astype(int))
        tried = np.unique(np.concatenate([edge, size - edge]))
        columns = (np.arange(size)[:, np.newaxis] >= tried).astype(np.float64)
        own = np.sum(alone.whiten(columns) ** 2, axis=0)
        flat = alone.precise(alone.whiten(np.ones(size)))
        from_the_end = np.cumsum(flat[::-1])[::-1]
        # Subtract the information that the run's own offset absorbs.
        information = np.exp(np.interp(np.arange(1, size), tried, np.log(own)))
        information -= from_the_end[1:] ** 2 / (from_the_end[0] + known_information)
        power = moment**2 / np.maximum(information, 1e-6 * float(own.max()))
        inside = slice(LEAST_STEP_ROWS - 1, size - LEAST_STEP_ROWS)
        of_run = [(places, power[inside])]
        if "stays" in effect.settings:
            channel = int(capture.run[part.start]) % capture.channels
            of_later, known = later.get(channel, (0.0, 0.0))
            both = np.maximum(information, 1e-6 * float(own.max())) + known
            of_run.append((staying, ((moment + of_later) ** 2 / both)[inside]))
            whole = float(from_the_end[0])
            later[channel] = (
                of_later + float(precise[part].sum()),
                known + whole * known_information / (whole + known_information),
            )
        for kind, heights in of_run:
            for index in peaks(heights, 2):
                row = part.start + int(index) + LEAST_STEP_ROWS
                place = {"run": float(capture.run[row]), "instant": float(capture.time_s[row])}
                kind.append((float(heights[index]), place))
        sizes.append(size)
    if effect.settings.get("stays"):
        found = _at_exact_instant(effect, residuals, _scored_steps(effect, residuals, staying))
    else:
        found = _scored_steps(effect, residuals, places)
    if staying and not effect.settings["stays"]:
        form = type(effect)(**{**effect.settings, "stays": True})
        lasting = _scored_steps(form, residuals, staying)
        if lasting and (not found or lasting[0].gain > found[0].gain + LEAST_LEAD):
            found = _at_exact_instant(form, residuals, lasting)
    if not found:
        return found
    channels = capture.channels
    forms = 2 if staying and not effect.settings["stays"] else 1
    heads = (channels + 1) / channels if channels > 1 else 1.0
    trials = forms * heads * sum(step_trials(found[0].gain, size) for size in sizes)
    return [replace(place, trials=trials) for place in found]


def _scored_steps(
    effect: Effect, residuals: Residuals, places: list[tuple[float, dict[str, float]]]
) -> list[Place]:
    """Return the exact gains of steps at the best of ``places``; with several channels, steps of
    head 1 at these places are tried too."""
    channels = residuals.observations.channels_of_capture
    best = [place for _, place in sorted(places, key=lambda item: -item[0])[:BEST_PLACES]]
    if channels > 1:
        # A step of head 1 is in every channel of a run; the value of ``run`` is then −1, −2, …
        best += [{**place, "run": -(place["run"] // channels) - 1.0} for place in best]
    return scored(effect, residuals, best, 1.0)


def _at_exact_instant(effect: Effect, residuals: Residuals, found: list[Place]) -> list[Place]:
    """Return the places; the first is moved to the instant in its run with the largest exact gain.

    The cumulative sums neglect that the model's columns absorb a part of a step that stays in the
    later runs, and therefore prefer a later instant.
    """
    capture = residuals.observations.capture
    if not found or capture is None:
        return found
    run, channels = round(found[0].nonlinear["run"]), capture.channels
    own_run = run // channels if run >= 0 else -run - 1
    times = np.unique(capture.time_s[capture.run // channels == own_run])
    low, high = LEAST_STEP_ROWS, times.size - LEAST_STEP_ROWS
    best = found[0]
    while high > low:
        tried = np.unique(np.linspace(low, high, STEP_PLACES).round().astype(int))
        places = [{**best.nonlinear, "instant": float(times[row])} for row in tried]
        moved = scored(effect, residuals, places, 1.0)
        if not moved:
            break
        best = max([best, *moved], key=lambda place: place.gain)
        if tried.size == high - low + 1:
            break
        at = int(np.argmin(np.abs(times[tried] - best.nonlinear["instant"])))
        low, high = int(tried[max(at - 1, 0)]), int(tried[min(at + 1, tried.size - 1)])
    return sorted([best, *found[1:]], key=lambda place: -place.gain)


BUMP_WIDTHS_DEG = 0.05 * 1.5 ** np.arange(14)
"""Widths σ of the bells that a scan tries, 0.05° to 9.7°; a ratio of 1.5 between neighbouring
widths suffices, because the best width is then moved to its maximum."""


def bump_scan(effect: Effect, residuals: Residuals) -> list[Place]:
    """Search place and width of a bell on the disc, by matched filters over the binned angle."""
    capture = residuals.observations.capture
    if capture is None or residuals.capture_precise is None:
        return []
    bins = 1 << 14
    spectra = disc_spectra(residuals, bins)
    spacing_deg = 360.0 / max(samples_a_turn(residuals), 1.0)
    orders = np.arange(spectra[0].size)
    known_information = order_information(residuals, orders.astype(np.float64))
    found: list[tuple[float, dict[str, float]]] = []
    trials = 0.0
    shifts = shifts_of_channels(capture, orders)
    for width in BUMP_WIDTHS_DEG:
        if width < 0.5 * spacing_deg:
            continue
        sigma = np.radians(width)
        bell = np.exp(-0.5 * (orders * sigma) ** 2)
        # Template g(θ + α − ψ₀) − g(θ − ψ₀): its transform is bell·(e^{jnα} − 1)·e^{−jnψ₀}.
        correlation, norm = np.zeros(bins), 0.0
        for spectrum, shift in zip(spectra, shifts, strict=True):
            template = bell * shift
            correlation += np.fft.irfft(spectrum * np.conj(template), bins)
            norm += np.fft.irfft(np.abs(template) ** 2 * known_information / bins, bins)[0] / len(
                spectra
            )
        # The graduation of the base model absorbs the low orders, which therefore give no evidence.
        power = correlation**2 / max(norm, 1e-30)
        for index in peaks(power, 2):
            found.append(
                (float(power[index]), {"place": 360.0 * index / bins, "width": float(width)})
            )
        trials += 360.0 / width
    found.sort(key=lambda item: -item[0])
    candidates = scored(effect, residuals, (item for _, item in found[:BEST_PLACES]), trials)
    if candidates:
        width = candidates[0].nonlinear["width"]
        candidates = moved_to_maximum(effect, residuals, candidates, "place", 0.5 * width)
        candidates = moved_to_maximum(effect, residuals, candidates, "width", 0.35 * width)
    return candidates


def grid_scan(effect: Effect, residuals: Residuals) -> list[Place]:
    """Score every point of the grid over the declared ranges, for effects without another kind of
    scan."""
    axes = []
    for parameter in effect.search:
        low, high = effect.search_range(parameter.name)
        points = np.linspace(low, high, parameter.steps)
        axes.append(np.unique(np.round(points)) if parameter.integer else points)
    names = [parameter.name for parameter in effect.search]
    if not names:
        return scored(effect, residuals, [{}], 1.0)
    places = [dict(zip(names, map(float, values), strict=True)) for values in product(*axes)]
    found = scored(effect, residuals, places, float(len(places)))
    for parameter in effect.search:
        if not parameter.integer:
            low, high = effect.search_range(parameter.name)
            step = (high - low) / max(parameter.steps - 1, 1)
            found = moved_to_maximum(effect, residuals, found, parameter.name, step)
    return found


__all__ = [
    "bump_scan",
    "disc_order_scan",
    "disc_spectra",
    "frequency_scan",
    "grid_scan",
    "highest",
    "moved_to_maximum",
    "peaks",
    "samples_a_turn",
    "scored",
    "stations_a_turn",
    "step_scan",
    "unwrapped_order_scan",
]
