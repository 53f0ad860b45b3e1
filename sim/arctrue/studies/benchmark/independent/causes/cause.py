"""A cause: where it enters the way from the table's angle to a recorded row."""

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
    """Drawn evenly in the logarithm."""
    return float(np.exp(random.uniform(np.log(low), np.log(high))))


class Cause:
    """Does nothing; a cause replaces the methods where it acts."""

    name = ""
    """Of the catalogue where ``known``, else a word of ours."""
    known = True
    """The catalogue has it."""
    columns = 1
    """Free coefficients of its exact form, for the oracle."""
    places = 1
    """What its search looks through, independent places, for the oracle."""
    unit = "arcsec"

    def __init__(self, size: float) -> None:
        """``size`` in ``unit``."""
        self.size = size

    def scaled(self, factor: float) -> Self:
        """The same cause, so many times as large."""
        found = copy(self)
        found.size = self.size * factor
        return found

    def wound_rad(self, at: Conditions) -> Float | float:
        """By how much the disc lags behind the table."""
        return 0.0

    def centre_m(self, at: Conditions) -> Complex | complex:
        """Where the disc's centre moves to in the stator's frame, x + jy."""
        return 0j

    def bracket_rad(self, at: Conditions, head: int) -> Float | float:
        """By how much the bracket of a head is turned about the axis, in the sense of β."""
        return 0.0

    def mark_rad(self, label_rad: Float, at: Conditions) -> Float | float:
        """Placement error of the marks."""
        return 0.0

    def signals(
        self, sine: Float, cosine: Float, head: int, label_rad: Float
    ) -> tuple[Float, Float]:
        """The head's two signals, which are sin and cos of the phase without a cause."""
        return sine, cosine

    def delay_s(self, head: int) -> float:
        """How old a reading of the head is."""
        return 0.0

    def slipped_counts(self, at: Conditions, head: int) -> Float | float:
        """Counts that the head's counter has gained."""
        return 0.0

    def reference_rad(self, at: Conditions, error_rad: Float) -> Float | float:
        """What the reference adds to the error that it is shown."""
        return 0.0

    def values(self) -> dict[str, tuple[float, ...]]:
        """What a search should find: ``order`` (a turn) or ``hz``, any of those listed."""
        return {}
