"""Finds a line (a sinusoidal error of any order or frequency) in the capture or the reference, for
the effect ``periodic_error``."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.line_spectrum import LineSpectrum, line_spectrum
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.maximum import moved_to_maximum
from arctrue.workbench.inference.scan.places import BEST_PLACES, Place, peaks, scored
from arctrue.workbench.observations.one_speed import speed_turns_s

Float = NDArray[np.float64]

HALF_ORDERS_TO = 30.5
"""Highest half-integer order that the search in the capture ignores, because products of parts
(condition × wave) explain such orders."""


def line_scan(effect: Effect, residuals: Residuals) -> list[Place]:
    """Return the best lines of both channels, over the angle and over time, best first.

    If all rows have one speed, a line in time is also a line in the angle; the search then covers
    the angle only.
    """
    coarse: list[tuple[float, dict[str, float], LineSpectrum]] = []
    trials = 0.0
    for capture in (False, True):
        highest_order = 0.0
        for in_time in (False, True):
            if in_time and highest_order and _one_speed(residuals, capture, highest_order):
                continue
            spectrum = line_spectrum(residuals, capture=capture, in_time=in_time)
            if spectrum is None or spectrum.rates.size == 0:
                continue
            highest_order = float(spectrum.rates[-1])
            gain = spectrum.gain
            if capture and not in_time:
                gain = np.where(_predicted_by_others(spectrum, residuals), 0.0, gain)
            trials += spectrum.trials
            for index in peaks(gain, BEST_PLACES):
                place = {
                    "order": 0.0 if in_time else float(spectrum.rates[index]),
                    "frequency": float(spectrum.rates[index]) if in_time else 0.0,
                    "in_time": float(in_time),
                    "in_capture": float(capture),
                }
                coarse.append((float(gain[index]), place, spectrum))
    coarse.sort(key=lambda item: -item[0])
    best = coarse[:BEST_PLACES]
    found = scored(effect, residuals, (place for _, place, _ in best), trials)
    if not found:
        return found
    spectrum = next(there for _, place, there in best if place == found[0].nonlinear)
    name = "frequency" if found[0].nonlinear["in_time"] else "order"
    refined = moved_to_maximum(effect, residuals, found, name, 0.5 / spectrum.span)
    low, high = effect.search_range(name)
    # A line of a lower rate than spectrum.lowest has too few periods and would be a slow curve.
    inside = max(low, spectrum.lowest) <= refined[0].nonlinear[name] <= high
    return refined if inside else found


def _one_speed(residuals: Residuals, capture: bool, highest_order: float) -> bool:
    rows = residuals.observations.capture if capture else residuals.observations.reference
    return rows is not None and speed_turns_s(rows, highest_order) is not None


def _predicted_by_others(spectrum: LineSpectrum, residuals: Residuals) -> NDArray[np.bool_]:
    """Return True for the orders of a capture that other effects explain: integers, and
    half-integers up to HALF_ORDERS_TO."""
    resolution = residuals.observations.order_resolution
    whole = np.abs(spectrum.rates - np.round(spectrum.rates)) < resolution
    twice = 2.0 * spectrum.rates
    half = np.abs(twice - np.round(twice)) / 2.0 < resolution
    return np.asarray(whole | (half & (spectrum.rates <= HALF_ORDERS_TO)))
