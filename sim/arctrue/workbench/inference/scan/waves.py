"""Scans for waves: of any order over the unwrapped angle, or of any frequency in time."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.fft import next_fast_len

from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.channels import channel_rows, power_of_channels
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.disc import order_information
from arctrue.workbench.inference.scan.maximum import moved_to_maximum
from arctrue.workbench.inference.scan.places import BEST_PLACES, Place, peaks, scored
from arctrue.workbench.inference.significance import trials_of_a_line

Float = NDArray[np.float64]

SEPARATING_GAIN = 30.0
"""Amount by which the gain of an order must exceed the gain of the nearest whole or half order. A
free order is one more parameter: chance causes this amount with a probability of 4·10⁻⁸, and of
5·10⁻⁶ in any of the 120 gaps up to order 60."""
IN_A_GAP = np.array([-1.2, -0.9, -0.6, -0.3, 0.3, 0.6, 0.9, 1.2])
"""Offsets at which orders near a whole or half order are scored, in the gap around it and next to
this gap, in units of the resolution 1/(2·turns). With T turns, neighbouring offsets differ by at
most 0.3/T, and the peak of a line in one run extends 0.5/T to either side, so that two neighbouring
offsets cannot both miss it.
"""


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
    # gap, the highest point may be the edge of the gap, which is not a local maximum.
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
    exactly its place is known (Rife and Boorstyn, IEEE Trans. Inf. Theory 20 (1974) 591): the order
    of a line differs from the whole or half order if the line's gain exceeds the gain at that order
    by SEPARATING_GAIN.
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


LONGEST_WINDOW = 1 << 19
"""Largest number of samples in one transform over time; padded with zeros, the transform has four
times as many samples, 16 MB."""


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
    trials = trials_of_a_line(
        bandwidths * longest, len(effect.column_names(residuals.observations))
    )
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
