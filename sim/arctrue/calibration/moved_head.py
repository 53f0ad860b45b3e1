"""Finds the head that has moved between two calibrations, from the offsets of all counters.

A head that moves along the scale by δ changes its own offset by δ. An axis that moves by c changes
the offset of every head by Im(c·e^{jp})·ρ, where p is the head's place and ρ its radius ratio. Four
heads show three changes relative to head 1. A move of any one head could explain these changes if
the axis also moved by some c. For the head that has really moved, and only for this head, c is
small.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.calibration.head_weights import translation_columns

Float = NDArray[np.float64]


@dataclass(frozen=True)
class MovedHead:
    """One explanation of the changes: ``head`` (1, 2, …; 0: none) moved, and the axis moved by x
    and y, arcseconds."""

    head: int
    moved_arcsec: float
    axis_arcsec: tuple[float, float]
    left_arcsec: float
    """RMS of the changes that the explanation does not cover."""

    @property
    def axis_moved_arcsec(self) -> float:
        """Distance by which the axis would have moved, as an angle at the disc's radius."""
        return float(np.hypot(*self.axis_arcsec))


def moved_heads(
    changes_arcsec: Sequence[float] | Float,
    places_rad: Float,
    radius_ratios: Float,
    *,
    axis_limit_arcsec: float,
    noise_arcsec: float,
) -> list[MovedHead]:
    """Return the possible explanations of the changes of all offsets, (heads,); in each of them the
    axis moves by at most ``axis_limit_arcsec``.

    ``noise_arcsec``: standard uncertainty of a change, including the repeatability of the index;
    the changes that an explanation does not cover may have an RMS of up to four times this value.
    "No head has moved" is an explanation too; if it is possible, only this explanation is returned.
    """
    changes = np.asarray(changes_arcsec, dtype=np.float64)
    heads = changes.size
    # Columns: the zero of all readings, the axis along y and x.
    common = np.column_stack((np.ones(heads), translation_columns(places_rad, radius_ratios)))
    found = []
    for head in range(heads + 1):
        own = np.zeros((heads, 1))
        if head:
            own[head - 1] = 1.0
        design = np.hstack((common, own)) if head else common
        values = np.linalg.lstsq(design, changes)[0]
        left = float(np.sqrt(np.mean((changes - design @ values) ** 2)))
        one = MovedHead(
            head,
            float(values[3]) if head else 0.0,
            (float(values[2]), float(values[1])),
            left,
        )
        if left <= 4.0 * noise_arcsec and one.axis_moved_arcsec <= axis_limit_arcsec:
            if head == 0:
                return [one]
            found.append(one)
    return found
