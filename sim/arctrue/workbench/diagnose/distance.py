"""Finds the ways in which a set differs from the sets on which the probabilities were calibrated.

A share of wrong answers that was counted on one kind of sets does not apply to another kind. The
simulated sets of the benchmark seldom or never have these differences.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from arctrue.workbench.inference.left import CHANNELS, Left
from arctrue.workbench.observations import Observations

LEAST_REPEATS = 3
"""Least number of runs of a capture, or of visits of a station: if two runs or visits differ,
nothing shows which of them is wrong.
"""
NOT_WHITE_P = 1e-4
"""If p of the test of whiteness is below this value, the noise model does not describe the noise;
the value equals the limit of a sure lack of fit."""
MUCH_LEFT = 1.5
"""Largest usual ratio of the remaining RMS to the noise of the repeats. If the ratio is larger, the
error that no effect explains is larger than the noise."""
LEAST_P = 1e-300
"""Smallest p value that is used: smaller values underflow in float64."""
MOST_UNTESTED = 1.0 / 3.0
"""Largest usual share of effects that a set cannot test; the usual set of the benchmark can test
all effects."""


def ways_unlike(
    observations: Observations, left: Left, untestable: Mapping[str, object], tested: int
) -> tuple[str, ...]:
    """Return, in words, each way in which a set differs from the benchmark's sets.

    ``left``: residual of the model with the stated effect; ``tested``: number of effects that were
    tested.
    """
    found = []
    capture, reference = observations.capture, observations.reference
    if capture is None:
        found.append("it has no capture of both heads")
    elif observations.recorded_runs < LEAST_REPEATS:
        found.append(f"its capture has fewer than {LEAST_REPEATS} runs")
    if observations.heads > 2:
        found.append(f"its capture has {observations.heads} heads")
    if reference is None:
        found.append("it has no reference")
    elif _visits(reference.target_rad) < LEAST_REPEATS:
        found.append(f"its stations were visited fewer than {LEAST_REPEATS} times")
    if len(untestable) > MOST_UNTESTED * (len(untestable) + tested):
        found.append("more than a third of the effects cannot be tested with it")
    both = left.residuals.capture_whiteness, left.residuals.reference_whiteness
    for channel, tests in zip(CHANNELS, both, strict=True):
        if tests is not None and tests.autocorrelation_p < NOT_WHITE_P:
            found.append(f"the residual of its {channel} is not white")
        noise = left.noise_arcsec.get(channel, 0.0)
        if left.rms_arcsec.get(channel, 0.0) > MUCH_LEFT * noise:
            found.append(f"its {channel} has a residual above its noise")
    return tuple(found)


@dataclass(frozen=True, slots=True)
class Distance:
    """Distance of a set from the sets on which the probabilities were calibrated."""

    untested: float
    """Share of the effects that the set cannot test."""
    runs: int
    """Number of runs of the capture; 0 without one."""
    visits: float
    """Median, over the stations, of the number of visits; 0 without a reference."""
    left: float
    """Largest ratio of the residual RMS to the noise of the repeats, over the channels."""
    not_white: float
    """−log₁₀ of the smallest p value of whiteness over the channels."""


def distance(
    observations: Observations, left: Left, untestable: Mapping[str, object], tested: int
) -> Distance:
    """Return the quantities that :func:`ways_unlike` compares with its limits."""
    reference = observations.reference
    ratios, least = [0.0], 1.0
    both = left.residuals.capture_whiteness, left.residuals.reference_whiteness
    for channel, tests in zip(CHANNELS, both, strict=True):
        if tests is not None:
            least = min(least, tests.autocorrelation_p)
        noise = left.noise_arcsec.get(channel, 0.0)
        if noise > 0.0:
            ratios.append(left.rms_arcsec.get(channel, 0.0) / noise)
    return Distance(
        untested=len(untestable) / max(len(untestable) + tested, 1),
        runs=observations.recorded_runs,
        visits=0.0 if reference is None else _visits(reference.target_rad),
        left=max(ratios),
        not_white=float(-np.log10(max(least, LEAST_P))),
    )


def _visits(target_rad: np.ndarray) -> float:
    """Return the median, over the stations, of the number of visits."""
    station = np.round(np.mod(np.round(target_rad / (2.0 * np.pi), 9), 1.0), 6)
    _, counts = np.unique(station, return_counts=True)
    return float(np.median(counts))
