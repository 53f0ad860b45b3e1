"""Tests whether the rounding of the reference's display can explain an effect.

Where the noise is smaller than the step of the display, each visit of a station is rounded in the
same way. The mean of the visits then keeps an error of up to half a step, which looks like an error
of the station: of a face of the polygon, or of a high order.
"""

from __future__ import annotations

import numpy as np
from scipy.special import chdtrc

from arctrue.workbench.diagnose.candidate import Candidate, changes_arcsec
from arctrue.workbench.inference.significance import SIGNIFICANCE
from arctrue.workbench.observations.display_step import display_step

DITHERED = 0.5
"""If the noise of a row has at least this number of display steps, the mean of many visits has no
rounding error. In normal noise of σ steps, this error is at most exp(−2π²σ²)/π steps, 0.2 % of a
step here."""
OF_THE_STATIONS = 0.9
"""Smallest share of an effect's variance that is the same at all visits of a station if the
rounding can cause the effect."""
SAME_STATION_DEG = 1e-4
"""Targets are rounded to this angle before equal ones are grouped to a station; the stations of a
polygon are thousands of times farther apart."""


LARGEST_LINE = 2.0 / np.pi
"""Largest amplitude of a line of the rounding error, in display steps. The error stays within half
a step, and the square wave of ±1/2 has the largest fundamental, 4/π·1/2."""


def rounded_at_the_stations(item: Candidate, noise_arcsec: float) -> float:
    """Return the step of the display in arcseconds if the rounding explains the effect in the
    reference; otherwise 0.

    A line of a log is explained if its amplitude is at most LARGEST_LINE steps: where the error
    changes slowly, the rounding changes as regularly as the error. For another effect the rounding
    is a random error of each station, uniform over a step. ``noise_arcsec``: noise of a row. The
    gain falls by the ratio of the variances of a station's mean without and with this error; with
    the lower gain, p of χ² must be at least SIGNIFICANCE.
    """
    rows = item.solution.observations.reference
    if rows is None:
        return 0.0
    step = display_step(rows.error_arcsec)
    if step == 0.0 or noise_arcsec >= DITHERED * step:
        return 0.0
    if item.regular is not None:
        largest = max(line.amplitude_arcsec for line in item.regular.lines)
        return step if largest <= LARGEST_LINE * step else 0.0
    before = item.solution if item.evidence is None else item.evidence.base.solution
    change = changes_arcsec(before, item.solution)["reference"]
    angle = np.round(np.degrees(rows.target_rad) % 360.0 / SAME_STATION_DEG)
    _, station, visits = np.unique(angle, return_inverse=True, return_counts=True)
    mean = np.bincount(station, change) / visits
    total = float(np.var(change))
    if total == 0.0 or float(np.var(mean[station])) < OF_THE_STATIONS * total:
        return 0.0
    of_mean = noise_arcsec**2 / float(np.mean(visits))
    gain = item.gain * of_mean / (of_mean + step**2 / 12.0)
    return step if float(chdtrc(item.rank, gain)) >= SIGNIFICANCE else 0.0
