"""Warns of a reference's columns that probably have another unit or sign than the format states."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.noise.repeats import reference_noise_arcsec
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.display_step import display_step

ARCSEC_PER_ARCMIN = 60.0
"""Ratio of the two smallest units of angle. Errors written in arcminutes, degrees or radians seem
to repeat at least this many times better than the stated uncertainty."""

LEAST_PLACES = 12
"""Fewest places that runs in both directions share. Twelve pairs of independent readings have a
correlation below -0.9 with a probability of 3e-5 (Student's t with ten degrees of freedom)."""
OPPOSITE = -0.9
"""Largest correlation of the errors upwards and downwards that counts as opposite: the part of the
error that changes its sign with the direction is then at least four times the part that does
not."""


def doubtful_columns(observations: Observations) -> list[str]:
    """Return the warnings of doubtful units and signs of the reference's columns."""
    return [*doubtful_units(observations), *opposite_signs(observations)]


def opposite_signs(observations: Observations) -> list[str]:
    """Return a warning if the errors of runs downwards are opposite to those of runs upwards.

    The means of both directions are compared at equal places. The overall mean of each direction is
    subtracted, because a reversal error changes it.
    """
    rows = observations.reference
    if rows is None or rows.direction is None:
        return []
    place = np.mod(rows.target_rad, 2.0 * np.pi).round(6).astype(np.float64)
    up, down = (_means(place, rows.error_arcsec, rows.direction == side) for side in (1, -1))
    shared = np.intersect1d(up[0], down[0])
    if shared.size < LEAST_PLACES:
        return []
    first, second = (mean[np.searchsorted(places, shared)] for places, mean in (up, down))
    if not (first.std() > 0.0 and second.std() > 0.0):
        return []
    correlation = float(np.corrcoef(first, second)[0, 1])
    if correlation > OPPOSITE:
        return []
    return [
        "the errors of the reference change their sign with the direction: at "
        f"{shared.size} places the means upwards and downwards have a correlation of "
        f"{correlation:.3f}: is the sign of error_arcsec right in both directions?"
    ]


def _means(
    place: NDArray[np.float64], error: NDArray[np.float64], chosen: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the places of the chosen rows, ascending, and the mean error at each."""
    places, index = np.unique(place[chosen], return_inverse=True)
    return places, np.bincount(index, weights=error[chosen]) / np.bincount(index)


def doubtful_units(observations: Observations) -> list[str]:
    """Return a warning if the errors repeat far better than the stated uncertainty of the
    reference.

    The rounding of the display counts as scatter, because readings that are all equal repeat
    exactly in any unit.
    """
    rows, stated = observations.reference, observations.reference_uncertainty_arcsec
    if rows is None or stated is None or rows.error_arcsec.size < 2:
        return []
    scatter = reference_noise_arcsec(observations, rows.error_arcsec)
    scatter = max(scatter, display_step(rows.error_arcsec) / np.sqrt(12.0))
    if scatter <= 0.0 or scatter * ARCSEC_PER_ARCMIN >= stated:
        return []
    return [
        f"the errors of the reference repeat to {scatter:.1g}″, and its stated standard "
        f"uncertainty is {stated:g}″: is error_arcsec in arcseconds, not in "
        "degrees, arcminutes or radians?"
    ]
