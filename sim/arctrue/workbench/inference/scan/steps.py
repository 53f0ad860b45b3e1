"""Scan for a step: the instant after which the residual of a run is higher or lower."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import log_ndtr, ndtr

from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.instants import (
    LEAST_STEP_ROWS,
    at_best_instant,
    spread_places,
)
from arctrue.workbench.inference.scan.places import BEST_PLACES, Place, peaks, scored
from arctrue.workbench.noise.row_noise import RowNoise

Float = NDArray[np.float64]

LEAST_LEAD = 10.0
"""Smallest difference of the gains at which a step that stays in the later runs replaces one that
ends with its run; a difference of ten (odds of 150 to 1) is strong evidence."""
LEAST_MOVED = 10.0
"""Smallest gain of a step whose instant is moved to the exact maximum. A step of a smaller gain is
never named: at a single instant its p is 0.002, and it is one of hundreds of instants."""


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
        tried = spread_places(size)
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
    form = effect
    found = _scored_steps(form, residuals, staying if effect.settings.get("stays") else places)
    if staying and not effect.settings["stays"]:
        lasting_form = type(effect)(**{**effect.settings, "stays": True})
        lasting = _scored_steps(lasting_form, residuals, staying)
        if lasting and (not found or lasting[0].gain > found[0].gain + LEAST_LEAD):
            form, found = lasting_form, lasting
    if not found:
        return found
    if found[0].gain > LEAST_MOVED:
        found = at_best_instant(form, residuals, found)
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
