"""Defines the base class of causes: a cause disturbs one step between the table's angle and a
recorded row."""

from __future__ import annotations

from copy import copy
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from arctrue.studies.benchmark.independent.conditions import Conditions

Float = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]
Random = np.random.Generator
ARCSEC = float(np.radians(1 / 3600))
MICROMETRE = 1e-6


def log_uniform(random: Random, low: float, high: float) -> float:
    """Draw a value between ``low`` and ``high`` whose logarithm is uniformly distributed."""
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


class Cause:
    """Base class that causes no error; each subclass overrides the method of the step that it
    disturbs."""

    name = ""
    """Name of the cause in the catalogue if ``known``, otherwise a name that only this generator
    uses."""
    known = True
    """Whether the workbench's catalogue of effects contains the cause."""
    columns = 1
    """Number of free coefficients in the exact form of the cause, for the oracle."""
    places = 1
    """Number of independent candidates (orders, frequencies or instants) that a search for the
    cause examines, for the oracle."""
    unit = "arcsec"

    def __init__(self, size: float) -> None:
        """Set the ``size``, in ``unit``."""
        self.size = size

    def scaled(self, factor: float) -> Self:
        """Return the same cause with its size multiplied by ``factor``."""
        found = copy(self)
        found.size = self.size * factor
        return found

    def wound_rad(self, at: Conditions) -> Float | float:
        """Return the angle by which the disc lags behind the table."""
        return 0.0

    def centre_m(self, at: Conditions) -> Complex | complex:
        """Return the displacement of the disc's centre in the stator's frame, x + jy."""
        return 0j

    def bracket_rad(self, at: Conditions, head: int) -> Float | float:
        """Return the angle by which a head's bracket is turned about the axis, in the positive
        direction of stator angles."""
        return 0.0

    def mark_rad(self, label_rad: Float, at: Conditions) -> Float | float:
        """Return the placement error of the disc's marks whose nominal angles are ``label_rad``."""
        return 0.0

    def signals(
        self, sine: Float, cosine: Float, head: int, label_rad: Float
    ) -> tuple[Float, Float]:
        """Return the head's two signals; without a cause they are sin and cos of the phase."""
        return sine, cosine

    def delay_s(self, head: int) -> float:
        """Return the time, in seconds, by which the head's reading is older than its row."""
        return 0.0

    def slipped_counts(self, at: Conditions, head: int) -> Float | float:
        """Return the counts that the head's counter has gained."""
        return 0.0

    def reference_rad(self, at: Conditions, error_rad: Float) -> Float | float:
        """Return the error that the reference adds to ``error_rad``, the quantity that the
        reference measures."""
        return 0.0

    def values(self) -> dict[str, tuple[float, ...]]:
        """Return the orders (per turn) under ``order`` or the frequencies under ``hz`` that a
        search should find."""
        return {}
