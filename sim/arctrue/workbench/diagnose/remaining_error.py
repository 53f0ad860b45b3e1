"""Describes the error that remains with the named effect in the model.

An effect of the catalogue has one size everywhere. If its size in a machine differs from place to
place, the remaining error is the effect's own prediction times a factor that depends on the place.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.design_matrix import channel_prediction
from arctrue.workbench.inference.left import CHANNELS, Left
from arctrue.workbench.observations.stations_a_turn import STATION_DECIMALS

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

ANGLE_BINS = 36
"""Number of places (parts of the turn, 10° each) of a capture; in a reference, each station is a
place."""
LEAST_OF_LEFT = 0.5
"""Smallest share of the remaining mean square above the noise that the variation must explain, so
that it is most of the remaining error."""
WITHIN_PLACES = 0.5
"""Smallest share of the effect's mean square that must come from variation within the places. With
a smaller share the effect is nearly constant at a place, and its size there cannot be distinguished
from any other error there."""
STANDARD_ERRORS = 5.0
"""Smallest excess of χ² over the places, in standard errors: chance exceeds it with a probability
of 3·10⁻⁷ (normal distribution), and only one grouping is tested.
"""


@dataclass(frozen=True)
class RemainingError:
    """The error that remains with the named effect in the model, by channel, and its
    description."""

    left_arcsec: Mapping[str, float]
    noise_arcsec: Mapping[str, float]
    channel: str | None = None
    """Channel in which the effect's size differs from place to place; None if the size does not
    differ."""
    variation: float = 0.0
    """Standard deviation, over the places, of the factor that multiplies the effect's size; 0.2 is
    ±20 %."""
    description: str | None = None
    """Best product of parts for the remaining error, in words."""

    @property
    def bare(self) -> bool:
        """True where an error remains and its form is not known."""
        return self.channel is None and self.description is None

    @property
    def sentence(self) -> str:
        """Describe the remaining error in a sentence for people."""
        channels = [self.channel] if self.channel is not None else list(self.left_arcsec)
        left = " and ".join(
            f"{name} {self.left_arcsec[name]:.3g}″ RMS (noise {self.noise_arcsec[name]:.2g}″)"
            for name in channels
        )
        if self.channel is not None:
            return (
                f"The size of the named effect differs by ±{100.0 * self.variation:.0f} % from "
                f"place to place; the remaining error: {left}."
            )
        # Another sentence of the report names a further effect; here, only a product of parts
        # describes the form.
        what = "" if self.description is None else f"; {self.description}"
        return f"With the named effect in the model an error remains: {left}{what}."


def remaining_error(
    left: Left, *, unknown: bool, description: str | None = None
) -> RemainingError | None:
    """Return the error that remains with the named effect as the last term of the model; None if it
    is not significant.

    ``unknown``: whether the diagnosis with the named effect in the model finds an unknown error.
    """
    for channel, noise in left.noise_arcsec.items():
        found = _variation(left, channel, noise)
        if found is not None:
            return RemainingError(left.rms_arcsec, left.noise_arcsec, channel, found)
    if not unknown:
        return None
    return RemainingError(left.rms_arcsec, left.noise_arcsec, description=description)


def _variation(left: Left, channel: str, noise_arcsec: float) -> float | None:
    """Return the standard deviation, over the places of one channel, of the factor that multiplies
    the effect's size; None if it is not significant."""
    solution = left.solution
    capture = channel == CHANNELS[0]
    observations = solution.observations
    if capture:
        residual, rows = solution.capture_residual_arcsec(), observations.capture
        place = None if rows is None else np.floor(_turn(rows.angle_rad) * ANGLE_BINS)
    else:
        residual, stations = solution.reference_residual_arcsec(), observations.reference
        # Angles are rounded before they wrap: 0 and a whole turn are one place.
        place = None if stations is None else np.round(_turn(stations.target_rad), STATION_DECIMALS)
    if place is None or residual is None or noise_arcsec <= 0.0:
        return None
    size = solution.part(len(solution.terms) - 1)
    own = np.zeros(solution.coefficients.size)
    own[size] = solution.coefficients[size]
    predicted = channel_prediction(
        solution.terms, own, observations, solution.context, capture=capture
    )
    _, group = np.unique(place, return_inverse=True)
    return varies(predicted, residual, group.reshape(-1), noise_arcsec)


def _turn(angle_rad: Float) -> Float:
    return np.asarray(np.mod(np.round(angle_rad / (2.0 * np.pi), 9), 1.0))


def varies(predicted: Float, residual: Float, place: Integer, noise: float) -> float | None:
    """Return the scatter over the places of the ratio of residual to prediction.

    Arrays have the shape (rows,). The result is None if the scatter is not significant, if it
    explains less than half of the residual above the noise, or if the prediction is nearly constant
    at each place.
    """
    predicted, residual = predicted - predicted.mean(), residual - residual.mean()
    inside, rest = _within(predicted, place), _within(residual, place)
    weight = np.bincount(place, weights=inside**2)
    total = float(weight.sum())
    if total <= WITHIN_PLACES * float(predicted @ predicted):
        return None
    determined = weight > 0.0
    product = np.bincount(place, weights=inside * rest)[determined]
    square = float(np.sum(product**2 / weight[determined]))
    places = int(determined.sum())
    beyond = square - places * noise**2
    excess = float(residual @ residual) - residual.size * noise**2
    if beyond < STANDARD_ERRORS * np.sqrt(2.0 * places) * noise**2:
        return None
    if beyond < LEAST_OF_LEFT * excess:
        return None
    return float(np.sqrt(beyond / total))


def _within(values: Float, place: Integer) -> Float:
    count = np.maximum(np.bincount(place), 1)
    return np.asarray(values - (np.bincount(place, weights=values) / count)[place])
