"""Noise of the readings that a compiled instrument can follow in every clock."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arctrue.table import PhysicalEffect, TableState

_KNOTS = 1 << 18


@dataclass(frozen=True)
class ReadingNoise(PhysicalEffect):
    """Smooth random noise of each head: what an interpolator of limited bandwidth lets through.

    Gaussian with the standard deviation ``rms_rad``; readings more than 4 × ``correlation_s`` apart
    are independent of each other, which makes the noise of captured samples white. It is a uniform
    cubic B-spline of normal numbers in the table's time, and begins anew after 262,144 of them.
    Effects of a table are taken in their order: put it last.
    """

    rms_rad: float
    correlation_s: float
    seed: int = 1
    _values: NDArray[np.float64] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Draw the numbers; raises ValueError for what is no noise."""
        if self.rms_rad < 0 or not self.correlation_s > 0:
            raise ValueError(
                f"noise needs an rms of 0 or more and a correlation time above 0, "
                f"found {self.rms_rad} rad and {self.correlation_s} s"
            )
        values = np.random.default_rng(self.seed).normal(0.0, 1.0, (2, _KNOTS))
        # Mean over the interval of the sum of the squared basis functions: 151/315 + 0.
        object.__setattr__(self, "_values", self.rms_rad / np.sqrt(151 / 315) * values)

    def signal_error_rad(
        self, head: int, disc_reading_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64]:
        """The noise of head 0 or 1 at the instants of ``state``, shape ``(n,)``."""
        place = state.time_s / self.correlation_s
        first = np.floor(place).astype(np.int64)
        u = place - first
        weights = (
            (1 - u) ** 3 / 6,
            (3 * u**3 - 6 * u**2 + 4) / 6,
            (-3 * u**3 + 3 * u**2 + 3 * u + 1) / 6,
            u**3 / 6,
        )
        noise = np.zeros_like(place)
        for offset, weight in enumerate(weights):
            noise += weight * self._values[head, (first + offset) % _KNOTS]
        return noise
