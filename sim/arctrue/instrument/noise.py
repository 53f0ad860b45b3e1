"""Makes noise of the readings that is smooth enough for a compiled instrument to follow in every
clock."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arctrue.generated.number_formats import HEADS_MAX
from arctrue.table import Cause, TableState

Float = NDArray[np.float64]

_KNOTS = 1 << 18
"""Number of knots in a block."""
_KEPT_BLOCKS = 4


@dataclass(frozen=True)
class ReadingNoise(Cause):
    """Smooth random noise of each head, limited to the bandwidth of an interpolator.

    The noise is Gaussian with the standard deviation ``rms_rad``. Readings more than 4 ×
    ``correlation_s`` apart are independent, so that the noise of captured samples is white. The
    noise is a uniform cubic B-spline in the table's time with normal random numbers as
    coefficients; each block of 262,144 numbers is drawn from its own seed. A table applies its
    causes in their order; this cause must be the last.
    """

    rms_rad: float
    """Standard deviation of the noise, radians."""
    correlation_s: float
    """A quarter of the time in seconds after which readings are independent."""
    seed: int = 1
    """Seed of the random numbers."""
    _blocks: dict[int, Float] = field(init=False, repr=False, compare=False, default_factory=dict)

    def __post_init__(self) -> None:
        """Raise ValueError for values that define no noise."""
        if self.rms_rad < 0 or not self.correlation_s > 0:
            raise ValueError(
                f"noise needs an rms of 0 or more and a correlation time above 0, "
                f"found {self.rms_rad} rad and {self.correlation_s} s"
            )

    def _block(self, number: int) -> Float:
        """Return the random numbers of one block for four heads, shape ``(4, _KNOTS)``; the latest
        blocks are cached."""
        if number not in self._blocks:
            while len(self._blocks) >= _KEPT_BLOCKS:
                del self._blocks[next(iter(self._blocks))]
            # Blocks before time 0 get odd seeds, all others even seeds, so that no two blocks have
            # the same seed.
            own = 2 * number if number >= 0 else -2 * number - 1
            seed = [self.seed, own] if own else self.seed
            values = np.random.default_rng(seed).normal(0.0, 1.0, (HEADS_MAX, _KNOTS))
            # The sum of the squared basis functions has the mean 151/315 over an interval.
            self._blocks[number] = self.rms_rad / np.sqrt(151 / 315) * values
        return self._blocks[number]

    def _numbers(self, head: int, knot: NDArray[np.int64]) -> Float:
        """Return the normal random number at each knot, shape ``(n,)``."""
        if not knot.size:
            return np.zeros(0)
        first, last = int(knot.min()) // _KNOTS, int(knot.max()) // _KNOTS
        if first == last:
            return np.asarray(self._block(first)[head, knot - first * _KNOTS])
        block = knot // _KNOTS
        found = np.empty(knot.size)
        for number in np.unique(block).tolist():
            inside = block == number
            found[inside] = self._block(number)[head, knot[inside] - number * _KNOTS]
        return found

    def signal_error_rad(
        self, head: int, disc_reading_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64]:
        """Return the noise of a head.

        Parameters
        ----------
        head : int
            Number of the head, from 0.
        disc_reading_rad : ndarray
            Angle that the lines state, shape (n,); it has no influence.
        state : TableState
            Instants of the requested values, shape (n,).

        Returns
        -------
        ndarray
            Noise, radians, shape (n,).
        """
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
            noise += weight * self._numbers(head, first + offset)
        return noise
