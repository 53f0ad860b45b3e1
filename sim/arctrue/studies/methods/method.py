"""Describes a calibration method: its source, its requirements, and the orders that it cannot
determine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from arctrue.calibration.harmonics import error_arcsec
from arctrue.studies.methods.world import Output, World

Float = NDArray[np.float64]
Integer = NDArray[np.int64]


@dataclass(frozen=True)
class Method:
    """Calibration method; ``run`` measures and returns the calibrated table's output."""

    name: str
    title: str
    source: str
    heads: int
    needs: str
    cannot_see: str
    run: Callable[[World], Output]
    output: Literal["head 1", "mean"] = "head 1"
    """Whether the angle is computed from head 1 or from the mean of all heads."""


def of_harmonics(orders: Integer, values: Float) -> Output:
    """Return the output R − Σ(c·cos(n·R) + s·sin(n·R)) of head 1; ``values`` are the c, then the s,
    in arcseconds."""
    return Output.of_head1(lambda reading_rad: error_arcsec(orders, values, reading_rad))


def fitted_harmonics(orders: Integer, reading_rad: Float, error: Float) -> Float:
    """Fit harmonics and a constant to ``error`` by least squares; return the harmonics,
    (2·orders,)."""
    phase = np.multiply.outer(reading_rad, orders.astype(np.float64))
    design = np.hstack([np.cos(phase), np.sin(phase), np.ones((reading_rad.size, 1))])
    return np.asarray(np.linalg.lstsq(design, error)[0][:-1])
