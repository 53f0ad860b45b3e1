"""Computes the residual error of a table for a given number of lanes, width of the cosine and
number of CORDIC iterations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import arcsec_per_count
from arctrue.gateware.harmonic_lane import lane_cosine
from arctrue.generated.number_formats import PHASE_WIDTH
from arctrue.studies.head_angle.maps import Disc

Float = NDArray[np.float64]

WIDTHS = (10, 12, 14, 16, 18, 20, 22)
ITERATIONS = (8, 10, 12, 14, 16, 18, 20)
LANES = (1, 2, 3, 4, 5, 6, 7, 8)
COUNTS_PER_REV = 1 << 24


def residual_of_lanes(disc: Disc, lanes: int) -> float:
    """Return the RMS, in arcseconds, of the orders that have no lane; the orders with the largest
    amplitudes have the lanes."""
    left = np.sort(disc.amplitude_arcsec)[::-1][lanes:]
    return float(np.sqrt(0.5 * np.sum(left**2)))


def cosine_rms(width: int, iterations: int, phases: int = 1 << 14) -> float:
    """Return the RMS error of the bit-true cosine over ``phases`` evenly spaced phases.

    Raises ValueError for a width or a number of iterations that the gateware does not support.
    """
    phase = np.arange(phases, dtype=np.int32) * np.int32((1 << PHASE_WIDTH) // phases)
    cosine = lane_cosine(phase, width, iterations) * 2.0 ** (2 - width)
    error = cosine - np.cos(phase * (2.0 * np.pi / (1 << PHASE_WIDTH)))
    return float(np.sqrt(np.mean(error**2)))


def residual_of_bits(disc: Disc, width: int, iterations: int) -> float:
    """Return the RMS error, in arcseconds, that the rounded cosine causes at the output if every
    order has a lane."""
    return cosine_rms(width, iterations) * float(np.linalg.norm(disc.amplitude_arcsec))


def rounding_arcsec() -> float:
    """Return the RMS error of rounding to a count, which more lanes or bits do not reduce."""
    return arcsec_per_count(COUNTS_PER_REV) / float(np.sqrt(12.0))


def residual_map(disc: Disc) -> Float:
    """Return the RMS error in arcseconds that the rounded cosine causes, ``(widths,
    iterations)``."""
    return np.array(
        [[residual_of_bits(disc, width, count) for count in ITERATIONS] for width in WIDTHS]
    )
