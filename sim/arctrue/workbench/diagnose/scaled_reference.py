"""Finds a reference whose errors are in another unit, from the error of the disc that two heads
show.

R₂ − R₁ gives the orders of the disc in arcseconds, without the reference. If the errors of the
reference are a small share of this error, and repeat better than any instrument, they are in a
larger unit.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.noise.doubtful_columns import doubtful_units
from arctrue.workbench.noise.repeats import reference_noise_arcsec
from arctrue.workbench.numeric.harmonics import disc_difference, harmonic_columns
from arctrue.workbench.observations import Observations

Float = NDArray[np.float64]

UNITS = {60.0: "arcminutes", 3600.0: "degrees", 180.0 * 3600.0 / np.pi: "radians"}
"""Arcseconds in each unit of an angle that an instrument or a program writes."""
MOST_ROWS = 30_000
"""Largest number of rows of the capture that are fitted, to limit the time."""
ORDERS = 10
"""Number of orders of the disc that are fitted: at 33° the heads do not see order 11."""
LEAST_SEEN = 0.3
"""Smallest factor with which R₂ − R₁ shows an order, 2·sin(nα/2): its uncertainty is then at most
three times that of a wave in R₂ − R₁."""
LEAST_EXPLAINED = 0.9
"""Smallest share of the square of the reference's errors that the error of the disc, times a
factor, explains; the phase of a single order then agrees within 18°."""
PRECISE = 0.02
"""Largest relative u of the factor."""
ROUNDED = 0.005
"""Further relative difference of the factor from a unit's, for the orders that are not fitted."""
FINEST_ARCSEC = 1e-3
"""No reference repeats to less than this scatter: autocollimators and ring lasers repeat to about
0.01″."""


def scaled_reference(observations: Observations) -> list[str]:
    """Describe the fault if the errors of the reference are the error of the disc in another
    unit."""
    rows, curve = observations.reference, _error_of_the_disc(observations)
    if rows is None or curve is None:
        return []
    own = rows.error_arcsec - rows.error_arcsec.mean()
    curve = curve - curve.mean()
    square, whole = float(curve @ curve), float(own @ own)
    if square <= 0.0 or whole <= 0.0 or own.size < 3:
        return []
    factor = float(own @ curve) / square
    left = own - factor * curve
    if factor == 0.0 or float(left @ left) > (1.0 - LEAST_EXPLAINED) * whole:
        return []
    sigma = float(np.sqrt(left @ left / (own.size - 2) / square)) / abs(factor)
    within = 3.0 * sigma + ROUNDED
    near = (name for size, name in UNITS.items() if abs(abs(factor) * size - 1.0) < within)
    unit = next(near, None)
    if sigma > PRECISE or unit is None:
        return []
    scatter = reference_noise_arcsec(observations, rows.error_arcsec)
    if scatter >= FINEST_ARCSEC and not doubtful_units(observations):
        # An instrument may see a small remainder, for example of a corrected angle.
        return []
    sign = ", with the other sign" if factor < 0.0 else ""
    return [
        f"reference: its errors are {abs(factor):.4g} times (u {abs(factor) * sigma:.1g}) those of "
        f"the disc, which the two heads show, and repeat to {scatter:.1g}″: they seem to be in "
        f"{unit}{sign}; expected error_arcsec in arcseconds"
    ]


def _error_of_the_disc(observations: Observations) -> Float | None:
    """Return the error of the disc by the capture alone at each row of the reference, arcseconds;
    None without a capture of two heads."""
    rows, reference = observations.capture, observations.reference
    if rows is None or reference is None:
        return None
    first = np.arange(rows.run.size) if rows.channel is None else np.flatnonzero(rows.channel == 0)
    first = first[:: max(first.size // MOST_ROWS, 1)]
    number = np.arange(1, ORDERS + 1)
    seen = np.abs(2.0 * np.sin(0.5 * number * rows.head_separation_rad)) >= LEAST_SEEN
    orders = number[seen].tolist()
    waves = disc_difference(rows.disc1_rad[first], rows.disc2_rad[first], orders)
    runs = rows.run[first, np.newaxis] == np.unique(rows.run[first])
    columns = np.hstack([waves, runs.astype(np.float64)])
    found = np.linalg.lstsq(columns, rows.difference_arcsec[first], rcond=1e-9)[0]
    return np.asarray(harmonic_columns(reference.angle_rad, orders) @ found[: waves.shape[1]])
