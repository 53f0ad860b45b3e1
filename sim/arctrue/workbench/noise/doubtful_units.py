"""Warns of columns of a reference that are probably in another unit than their names state."""

from __future__ import annotations

import numpy as np

from arctrue.workbench.noise.repeats import reference_noise_arcsec
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.display_step import display_step

ARCSEC_PER_ARCMIN = 60.0
"""Ratio of the two smallest units of angle: errors in arcminutes, degrees or radians repeat at
least this many times better than the stated uncertainty."""


def doubtful_units(observations: Observations) -> list[str]:
    """Return a warning if the errors repeat far better than the stated uncertainty of the
    reference.

    The rounding of the display counts as scatter: readings that are all equal show no unit.
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
