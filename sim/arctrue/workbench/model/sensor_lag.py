"""Fits the time constant of a set's thermometer as a parameter of the temperature effects.

A thermometer with a first-order lag shows T_s with T_s′ = (T − T_s)/τ, so that the table's
temperature is T = T_s + τ·T_s′. The effects of a model that depend on T fit best with the true τ.
The fitted time constant is the maximum of the profile likelihood over τ, with all coefficients
fitted anew for each τ; the curvature there gives its standard uncertainty.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from arctrue.base.runs import run_spans
from arctrue.measurement import Capture, MeasurementSet, Reference
from arctrue.workbench.effects.base import Effect, Parameter
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.model.model import Model
from arctrue.workbench.noise.noise import Noise
from arctrue.workbench.observations import Observations

Float = NDArray[np.float64]
Channel = TypeVar("Channel", Capture, Reference)

LONGEST_S: Final = 3600.0
"""Largest time constant that the firmware holds."""
TRIED_S: Final = (0.0, *(float(5 * 2**step) for step in range(10)), LONGEST_S)
"""Time constants that are compared first, seconds; the best one is then refined between its
neighbours."""
SLOPE_SHARE: Final = 16.0
"""Ratio of the time constant to half the window of the parabola that gives the slope of T_s."""
LEAST_HALF_WINDOW_S: Final = 1.0
"""Smallest half window of the parabola, seconds, a choice."""
WINDOWS_MOST: Final = 500
"""Largest number of half windows in a run."""
PIECES: Final = 4
"""Number of pieces of half a window; the rows of a piece are averaged before the parabola is
fitted."""
TOLERANCE: Final = 1e-3
"""Relative tolerance of the time constant, far below its relative uncertainty."""


class NoLagError(ValueError):
    """The set or the model cannot determine the time constant; the message states the reason."""


def slope_k_s(
    temperature_c: Float, time_s: Float, run: NDArray[np.int64], window_s: float
) -> Float:
    """Return dT_s/dt, K/s, (rows,): slope of a parabola through the run's rows within ``window_s``.

    The window reaches ``window_s`` to each side, or 1/WINDOWS_MOST of the run if this is longer.
    The slope is computed at instants a quarter of this distance apart and interpolated linearly
    between these instants. At the ends of a run, all rows are on one side of the instant. A
    parabola still gives the slope at that instant; a straight line would give the slope in the
    middle of the rows.
    """
    found = np.zeros_like(temperature_c)
    for first, last in run_spans(run):
        rows = first + np.argsort(time_s[first:last], kind="stable")
        time, shown = time_s[rows] - time_s[rows[0]], temperature_c[rows]
        half_s = max(window_s, time[-1] / WINDOWS_MOST)
        pieces = max(int(np.ceil(PIECES * time[-1] / half_s)), 1)
        knots = np.linspace(0.0, time[-1], pieces + 1)
        slopes = _slopes_at(knots, time, shown)
        found[rows] = np.interp(time, knots, slopes)
    return found


def _slopes_at(knots: Float, time_s: Float, shown: Float) -> Float:
    """Return the slope at each knot, (knots,), of the parabola through the pieces to either side.

    A piece reaches from one knot to the next. The parabola is fitted to the means of the pieces,
    weighted by their numbers of rows. The mean of a parabola over a piece differs from its value in
    the middle by a constant, which does not change the slope.
    """
    pieces = knots.size - 1
    if time_s[-1] == 0.0:
        return np.zeros_like(knots)
    piece = np.minimum((time_s / time_s[-1] * pieces).astype(np.int64), pieces - 1)
    rows = np.bincount(piece, minlength=pieces).astype(np.float64)
    some = np.maximum(rows, 1.0)
    at_s = np.bincount(piece, time_s, minlength=pieces) / some
    mean = np.bincount(piece, shown - shown[0], minlength=pieces) / some
    # Each knot uses PIECES pieces before it and PIECES after it; pieces outside the run get the
    # weight 0.
    near = np.arange(knots.size)[:, np.newaxis] + np.arange(-PIECES, PIECES)
    weight = np.where((near >= 0) & (near < pieces), rows[np.clip(near, 0, pieces - 1)], 0.0)
    near = np.clip(near, 0, pieces - 1)
    half_s = PIECES * (knots[1] - knots[0])
    since = (at_s[near] - knots[:, np.newaxis]) / half_s
    powers = since[..., np.newaxis] ** np.arange(3)
    # Two pieces with rows determine a straight line; a single piece determines no slope.
    filled = np.count_nonzero(weight, axis=1)
    powers[filled < 3, :, 2] = 0.0
    powers[filled < 2, :, 1] = 0.0
    root = np.sqrt(weight)[..., np.newaxis]
    inverse = np.linalg.pinv(root * powers)
    fitted = inverse @ (root * mean[near][..., np.newaxis])
    return np.asarray(fitted[:, 1, 0] / half_s)


def without_lag(
    temperature_c: Float, time_s: Float, run: NDArray[np.int64], time_constant_s: float
) -> Float:
    """Return the table's temperature T, °C, (rows,), from the reading of its thermometer."""
    if time_constant_s == 0.0:
        return temperature_c
    window_s = max(time_constant_s / SLOPE_SHARE, LEAST_HALF_WINDOW_S)
    return np.asarray(
        temperature_c + time_constant_s * slope_k_s(temperature_c, time_s, run, window_s)
    )


def set_without_lag(measurement: MeasurementSet, time_constant_s: float) -> MeasurementSet:
    """Return the set with the table's temperature in place of the thermometer's reading."""
    return replace(
        measurement,
        capture=_channel(measurement.capture, time_constant_s),
        reference=_channel(measurement.reference, time_constant_s),
    )


def _channel(rows: Channel | None, time_constant_s: float) -> Channel | None:
    if rows is None or rows.temperature_c is None or rows.time_s is None:
        return rows
    run = np.zeros(rows.time_s.size, dtype=np.int64) if rows.run is None else rows.run
    warm = without_lag(rows.temperature_c, rows.time_s, run, time_constant_s)
    return replace(rows, temperature_c=warm)


def fitted_sensor_lag(
    model: Model, observations: Observations, effects: Mapping[str, type[Effect]]
) -> Parameter:
    """Fit the time constant of the thermometer, seconds, with its standard uncertainty.

    ``model`` contains the values of its search parameters; its coefficients are fitted here. Raises
    NoLagError if the set has no capture with temperatures, or if the standard uncertainty is not
    below LONGEST_S.
    """
    rows = observations.capture
    if rows is None or rows.temperature_c is None:
        raise NoLagError("a fit of the thermometer's lag needs a capture with temperature_c")
    terms = [Term(entry.effect(effects), entry.search) for entry in model.effects]
    noise: Noise | None = None
    known: dict[float, float] = {}

    def likelihood(time_constant_s: float) -> float:
        if time_constant_s not in known:
            shifted = _shifted(observations, time_constant_s)
            known[time_constant_s] = fit(terms, shifted, noise=noise).log_likelihood
        return known[time_constant_s]

    best = 0.0
    # The noise is estimated at the best τ; at another τ it would contain the error of that τ.
    for _ in range(2):
        noise = fit(terms, _shifted(observations, best)).noise
        known.clear()
        tried = max(range(len(TRIED_S)), key=lambda place: likelihood(TRIED_S[place]))
        low, high = TRIED_S[max(tried - 1, 0)], TRIED_S[min(tried + 1, len(TRIED_S) - 1)]
        found = minimize_scalar(
            lambda value: -likelihood(float(value)),
            bounds=(low, high),
            method="bounded",
            options={"xatol": TOLERANCE * high},
        )
        best = max((low, float(found.x), high), key=likelihood)
    sigma = _sigma_s(likelihood, best)
    if not sigma < LONGEST_S:
        raise NoLagError(
            "the set does not determine the lag of its thermometer: no effect of the model "
            "follows a temperature that changes at more than one rate"
        )
    return Parameter(best, sigma, "s")


def _sigma_s(likelihood: Callable[[float], float], best_s: float) -> float:
    """Return the standard uncertainty, seconds, from the curvature of the log likelihood; infinite
    if it is flat.
    """
    step = max(0.05 * best_s, 1.0)
    if best_s < step:
        # If the best τ is near 0, the uncertainty is the distance at which a parabola through the
        # log likelihood has fallen by 0.5.
        fall = likelihood(best_s) - likelihood(best_s + step)
        return step / np.sqrt(2.0 * fall) if fall > 0.0 else np.inf
    sides = likelihood(best_s - step) + likelihood(best_s + step)
    curvature = (2.0 * likelihood(best_s) - sides) / step**2
    return 1.0 / np.sqrt(curvature) if curvature > 0.0 else np.inf


def _shifted(observations: Observations, time_constant_s: float) -> Observations:
    rows, reference = observations.capture, observations.reference
    assert rows is not None
    assert rows.temperature_c is not None
    warm = without_lag(rows.temperature_c, rows.time_s, rows.run, time_constant_s)
    if reference is not None:
        shown, time_s = reference.temperature_c, reference.time_s
        if shown is not None and time_s is not None:
            warm_there = without_lag(shown, time_s, reference.run, time_constant_s)
            reference = replace(reference, temperature_c=warm_there)
    return replace(
        observations,
        capture=replace(rows, temperature_c=warm),
        reference=reference,
        stored=None,
        stored_reference=None,
    )
