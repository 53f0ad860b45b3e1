"""Converts units of angle: arcseconds, radians, counts.

Inside the package, angles are in radians; a value in another unit has this unit in its name.
"""

from __future__ import annotations

import math

ARCSEC_PER_TURN = 1_296_000
ARCSEC_PER_DEG = 3600.0
ARCSEC_PER_RAD = ARCSEC_PER_TURN / (2.0 * math.pi)
RAD_PER_ARCSEC = 2.0 * math.pi / ARCSEC_PER_TURN


def arcsec_per_count(counts_per_rev: int) -> float:
    """Return the arcseconds per count, for instance 0.0772″ at 2²⁴ counts per turn (the paper
    prints 0.772″)."""
    return ARCSEC_PER_TURN / counts_per_rev


def rad_per_count(counts_per_rev: int) -> float:
    """Return the radians per count."""
    return 2.0 * math.pi / counts_per_rev
