"""Checks the standard uncertainties that a set states for its rows."""

from __future__ import annotations

import numpy as np

from arctrue.measurement.measurement_set import Capture, Reference


def of_zero(rows: Capture | Reference, place: str, first_row: int) -> list[str]:
    """Return a warning if a used row has the standard uncertainty 0, otherwise an empty list.

    Such a row would have an infinite weight, so that the fit does not use the column. ``place``:
    file of the rows, or their name; ``first_row``: number of the first row in the message, for a
    file its line number (2, after the header).
    """
    if rows.u_arcsec is None:
        return []
    used = np.ones(rows.u_arcsec.size, dtype=bool) if rows.mask is None else ~rows.mask
    wrong = np.flatnonzero((rows.u_arcsec == 0.0) & used)
    if wrong.size == 0:
        return []
    return [
        f"{place}, row {wrong[0] + first_row}, column u_arcsec: expected more than 0, found 0, as "
        f"in {wrong.size} of {used.size} rows; the column is not used, because a row without "
        "uncertainty would have an infinite weight: state the uncertainty of these rows, or mask "
        "them"
    ]
