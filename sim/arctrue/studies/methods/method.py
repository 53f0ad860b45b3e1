"""What is said of a method: its sources, what it needs, what it cannot see."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.calibration.harmonics import error_arcsec
from arctrue.studies.methods.world import Correction, World

Float = NDArray[np.float64]
Integer = NDArray[np.int64]


@dataclass(frozen=True)
class Method:
    """One way to calibrate; ``run`` measures and returns the correction of head 1."""

    name: str
    title: str
    source: str
    heads: int
    needs: str
    cannot_see: str
    run: Callable[[World], Correction]


def of_harmonics(orders: Integer, values: Float) -> Correction:
    """Σ cosine·cos(n·R) + sine·sin(n·R); ``values`` arcseconds, (2·orders,), cosines first."""
    return lambda reading_rad: error_arcsec(orders, values, reading_rad)


def fitted_harmonics(orders: Integer, reading_rad: Float, error: Float) -> Float:
    """Harmonics of ``error`` at ``reading_rad`` by least squares, with a constant; (2·orders,)."""
    phase = np.multiply.outer(reading_rad, orders.astype(np.float64))
    design = np.hstack([np.cos(phase), np.sin(phase), np.ones((reading_rad.size, 1))])
    return np.asarray(np.linalg.lstsq(design, error)[0][:-1])
