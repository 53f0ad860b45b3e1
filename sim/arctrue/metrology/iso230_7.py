"""Computes the error motion of an axis according to ISO 230-7: total, synchronous and asynchronous
values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]

BINS = 180
"""Number of bins of the polar plot; each bin of two degrees contains about 67 of the 12,000 samples
in a turn."""


@dataclass(frozen=True)
class ErrorMotion:
    """Radial error motion in a fixed sensitive direction, in the unit of the displacements.

    Two circles about the centre of the least-squares circle enclose the polar plot, and the
    difference of their radii is the value of the plot. ``total`` is the value of the plot of all
    turns, ``synchronous`` the value of the plot of the mean turn. ``asynchronous`` is the largest
    width of the plot at one angle. ``total`` and ``asynchronous`` include the noise of the reading.
    """

    total: float
    synchronous: float
    asynchronous: float
    mean: Float
    """Mean displacement of all turns in each of BINS angles, relative to the centre of the
    least-squares circle; NaN in a bin without a sample."""


def error_motion(angle_rad: Float, displacement: Float) -> ErrorMotion:
    """Compute the error motion from displacements (n,) at angles (n,) over one turn or more.

    The centre of the least-squares circle is the component of order 1 (ISO 230-7, 3.4). A single
    turn does not separate the synchronous from the asynchronous part: ``asynchronous`` is then the
    width within a bin.
    """
    columns = np.stack([np.ones_like(angle_rad), np.cos(angle_rad), np.sin(angle_rad)], axis=1)
    centre, *_ = np.linalg.lstsq(columns, displacement, rcond=None)
    motion = displacement - columns @ centre
    place = (np.mod(angle_rad / (2.0 * np.pi), 1.0) * BINS).astype(np.int64) % BINS
    number = np.bincount(place, minlength=BINS)
    with np.errstate(invalid="ignore"):
        mean = np.bincount(place, weights=motion, minlength=BINS) / number
    high, low = np.full(BINS, -np.inf), np.full(BINS, np.inf)
    np.maximum.at(high, place, motion)
    np.minimum.at(low, place, motion)
    there = number > 0
    return ErrorMotion(
        float(motion.max() - motion.min()),
        float(np.nanmax(mean) - np.nanmin(mean)),
        float((high[there] - low[there]).max()),
        mean,
    )
