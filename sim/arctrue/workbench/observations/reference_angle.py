"""Calculates the reading of head 1 and the true angle of the table in the rows of a reference."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.measurement import Reference, Table
from arctrue.measurement.error_sign import is_opposite
from arctrue.workbench.numeric.harmonics import harmonic_columns
from arctrue.workbench.observations.true_angle import ORDERS

Float = NDArray[np.float64]

LARGEST_ERROR_RAD = 0.05
"""Largest distance of a reading from its target. A larger distance means that the reading has
another zero or another number of counts per turn."""
LARGEST_GAP_RAD = np.radians(30.0)
"""Smallest gap in the turn that makes the rows an arc. Orders up to 20 that approximate a straight
line leave 385″ RMS with a gap of 30°, 1.7″ with 60° and 0.006″ with 90° (rate of a Fourier
extension: Huybrechs, SIAM J. Numer. Anal. 47 (2010) 4326); the error of a table is between these
values."""
ARC_CONDITION = 1e-6
"""The fit over an arc sets singular values below this share of the largest one to zero, because the
rows of an arc cannot separate all orders."""
SAME_ANGLE_RAD = 0.1 * RAD_PER_ARCSEC
"""Rounding of a file. The target is the angle of the reference if reading − target − error scatters
by less than this value plus a tenth of the error's scatter."""
MOST_FITTED = 20_000
"""The fit over more rows uses evenly spread rows; their number is at least this value and less than
twice this value."""


def reading_and_angle(facts: Table, columns: Reference) -> tuple[Float, Float]:
    """Return the reading of head 1 and the angle θ of the table in every row, radians; (rows,).

    θ = R − ε. Over an arc, the measured ε is replaced by its first orders if the target is the
    commanded angle. Without this replacement, θ would contain the noise of ε. The orders of an arc
    can approximate a drift in time, but the difference between the drift and these orders would
    equal this noise, and a fit would assign the noise to the drift. If readings are missing or do
    not fit their targets, reading and angle are the target. If the errors have the opposite sign,
    the angle is the target.
    """
    target = np.radians(columns.target_deg)
    away = _away(facts, columns, target)
    if away is None:
        return target, target
    reading = np.asarray(target + away)
    if is_opposite(columns, facts.counts_per_rev):
        return reading, target
    error = (columns.error_arcsec - float(np.mean(columns.error_arcsec))) * RAD_PER_ARCSEC
    measured = float(np.std(away - error)) < SAME_ANGLE_RAD + 0.1 * float(np.std(error))
    if not measured and _is_arc(target):
        error = _first_orders(reading, error)
    return reading, reading - error


def _away(facts: Table, columns: Reference, target: Float) -> Float | None:
    """Return reading − target; None if readings are missing or one of them does not fit its
    target."""
    if columns.head1_counts is None or facts.counts_per_rev is None or target.size == 0:
        return None
    away = columns.head1_counts * (2.0 * np.pi / facts.counts_per_rev) - target
    # The file may unwrap only one of reading and target.
    away -= np.round(away / (2.0 * np.pi)) * (2.0 * np.pi)
    return None if float(np.abs(away).max()) > LARGEST_ERROR_RAD else away


def _is_arc(angle_rad: Float) -> bool:
    """Tell whether the rows leave a gap in the turn of more than LARGEST_GAP_RAD."""
    place = np.sort(np.mod(angle_rad, 2.0 * np.pi))
    gaps = np.append(np.diff(place), place[0] + 2.0 * np.pi - place[-1])
    # Stations of a polygon may be as far apart as the limit, and a file rounds them.
    return bool(gaps.max() > 1.001 * LARGEST_GAP_RAD)


def _first_orders(angle_rad: Float, values: Float) -> Float:
    """Return the part of the values that ORDERS and a constant describe; (rows,)."""
    columns = np.column_stack([np.ones(angle_rad.size), harmonic_columns(angle_rad, ORDERS)])
    thin = slice(None, None, max(angle_rad.size // MOST_FITTED, 1))
    found = np.linalg.lstsq(columns[thin], values[thin], rcond=ARC_CONDITION)[0]
    return np.asarray(columns @ found)
