"""Checks that the errors of a reference have the sign of the readings of the same rows."""

from __future__ import annotations

import numpy as np

from arctrue.base.units import ARCSEC_PER_TURN
from arctrue.measurement.measurement_set import Reference, Table

SAME = 0.1
"""Largest scatter of head1 − target + error, relative to that of head1 − target − error, at which
the sign counts as opposite. It is not 0, because rounded counts and targets leave some scatter."""


def is_opposite(reference: Reference, counts_per_rev: int | None) -> bool:
    """Tell whether the error column is target − head1 plus a constant, in place of head1 − target.

    If head1 follows the target (the drive brings the reading to the commanded angle), both scatters
    are equal, and the columns do not show the sign.
    """
    if reference.head1_counts is None or counts_per_rev is None or reference.target_deg.size < 3:
        return False
    away = reference.head1_counts * (ARCSEC_PER_TURN / counts_per_rev)
    away = away - reference.target_deg * (ARCSEC_PER_TURN / 360.0)
    away -= ARCSEC_PER_TURN * np.round((away - away[0]) / ARCSEC_PER_TURN)
    opposite, same = (float(np.std(away + sign * reference.error_arcsec)) for sign in (1.0, -1.0))
    return opposite < SAME * same


def of_opposite_sign(reference: Reference, table: Table, place: str) -> list[str]:
    """Return a warning if the errors have the opposite sign, otherwise an empty list. ``place``:
    file of the rows, or their name."""
    if not is_opposite(reference, table.counts_per_rev):
        return []
    return [
        f"{place}, column error_arcsec: expected reading of head 1 minus reference, found the "
        "opposite sign (target_deg minus head1_counts). The angle of the table is taken from "
        "target_deg; a correction from this set would double the error. Change the sign of "
        "the column"
    ]
