"""In how many ways a set is unlike those on which the probabilities were calibrated.

A share of wrong answers that was counted on one kind of sets says nothing of another kind. Each way
is one that the simulated sets of the benchmark do not have, or have seldom.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from arctrue.workbench.inference.left import CHANNELS, Left
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.noise.whiteness import whiteness
from arctrue.workbench.observations import Observations

LEAST_REPEATS = 3
"""Runs of a capture, or visits of a station: with fewer, nothing says which one is off."""
NOT_WHITE_P = 1e-4
"""As sure as a lack of fit: the noise is of a kind that the model of the noise does not have."""
MUCH_LEFT = 1.5
"""RMS that is left, in noises of the repeats: more than the noise again is not explained."""
MOST_UNTESTED = 1.0 / 3.0
"""Of the effects, those that the set cannot test: the usual set of the benchmark tests all."""


def ways_unlike(
    observations: Observations, left: Left, untestable: Mapping[str, object], tested: int
) -> tuple[str, ...]:
    """The ways in words. ``left``: of the model with what is spoken of; ``tested``: effects."""
    found = []
    capture, reference = observations.capture, observations.reference
    if capture is None:
        found.append("it has no capture of both heads")
    elif capture.runs < LEAST_REPEATS:
        found.append(f"its capture has fewer than {LEAST_REPEATS} runs")
    if reference is None:
        found.append("it has no reference")
    elif _visits(reference.target_rad) < LEAST_REPEATS:
        found.append(f"its stations were visited fewer than {LEAST_REPEATS} times")
    if len(untestable) > MOST_UNTESTED * (len(untestable) + tested):
        found.append("it cannot test more than a third of the effects")
    residuals = Residuals(left.solution)
    values = residuals.capture_whitened, residuals.reference_whitened
    for channel, whitened in zip(CHANNELS, values, strict=True):
        tests = None if whitened is None else whiteness(whitened)
        if tests is not None and tests.autocorrelation_p < NOT_WHITE_P:
            found.append(f"the noise of its {channel} is of another kind")
        noise = left.noise_arcsec.get(channel, 0.0)
        if left.rms_arcsec.get(channel, 0.0) > MUCH_LEFT * noise:
            found.append(f"its {channel} has more left than its noise")
    return tuple(found)


def _visits(target_rad: np.ndarray) -> float:
    """Of the station in the middle, how often it was visited."""
    station = np.round(np.mod(np.round(target_rad / (2.0 * np.pi), 9), 1.0), 6)
    _, counts = np.unique(station, return_counts=True)
    return float(np.median(counts))
