"""Detects trends in the orders of the error from the telemetry of a device over many turns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Float = NDArray[np.float64]

BLOCK_TURNS = 16
"""Number of turns in a mean; it exceeds the time constant of the firmware's running average (5
turns for ``keep`` 0.8)."""
BLOCKS = 8
"""Number of means through which a line is fitted."""
FALSE_ALARMS = 1e-3
"""Largest probability that one test reports a trend of any order if there is only noise."""


@dataclass(frozen=True, slots=True)
class Trend:
    """The trend of one order of the error."""

    order: int
    cosine_arcsec: float
    """Change of the coefficient of cos nθ from the first mean to the last mean."""
    sine_arcsec: float
    u_arcsec: float
    """Standard uncertainty of each of the two coefficients' changes, from the scatter of the means
    about the line."""
    turns: int
    """Number of turns between the middles of the first mean and the last mean."""
    chance: float
    """Probability that noise alone gives a trend of this order that is at least as large."""

    @property
    def change_arcsec(self) -> float:
        """Change of the order's components, as an amplitude."""
        return float(np.hypot(self.cosine_arcsec, self.sine_arcsec))

    def __str__(self) -> str:
        """Return a sentence for the user about the change."""
        return (
            f"order {self.order} changes by {self.change_arcsec:.2g}″ in {self.turns} turns "
            f"(u = {self.u_arcsec:.1g}″)"
        )


class TrendWatch:
    """Tests the latest ``BLOCKS`` means of ``BLOCK_TURNS`` turns whenever a mean is complete.

    The test fits a line through the means of the cosine coefficients, and another through those of
    the sine coefficients. An F test with 2 and 2·(BLOCKS − 2) degrees of freedom compares the
    slopes with the scatter about the lines. The noise of a turn need not be known. The test reports
    no change below ``matters_arcsec`` from the first mean to the last.
    """

    def __init__(
        self,
        matters_arcsec: float = 0.0,
        *,
        block_turns: int = BLOCK_TURNS,
        blocks: int = BLOCKS,
        false_alarms: float = FALSE_ALARMS,
    ) -> None:
        """Create the test. Raises ValueError for fewer than three blocks, because a line through
        two has no scatter."""
        if blocks < 3 or block_turns < 1:
            raise ValueError("expected three blocks or more, of one turn or more")
        self._matters_arcsec, self._false_alarms = matters_arcsec, false_alarms
        self._block_turns, self._blocks = block_turns, blocks
        self._last = -1
        self._turns: list[tuple[float, dict[int, complex]]] = []
        self._means: list[tuple[float, dict[int, complex]]] = []

    def add(self, turn: int, harmonics: Sequence[Sequence[float]]) -> list[Trend]:
        """Return the orders with a trend, strongest first; the list is empty until a further mean
        is complete.

        Each entry of ``harmonics`` begins with order, amplitude in arcseconds and phase in radians,
        as in the telemetry. ``harmonics`` is empty for a refused turn; such turns and repeated
        lines are skipped.
        """
        if not harmonics or turn == self._last:
            return []
        values = {int(h[0]): h[1] * np.exp(-1j * h[2]) for h in harmonics}
        known = self._turns or self._means
        if turn < self._last or (known and set(known[0][1]) != set(values)):
            # After a restart, or if the orders change, earlier means cannot be compared with new
            # ones.
            self._turns, self._means = [], []
        self._last = turn
        self._turns.append((float(turn), values))
        if len(self._turns) < self._block_turns:
            return []
        middle = float(np.mean([number for number, _ in self._turns]))
        self._means.append(
            (middle, {n: complex(np.mean([v[n] for _, v in self._turns])) for n in values})
        )
        self._turns = []
        self._means = self._means[-self._blocks :]
        return self._judge() if len(self._means) == self._blocks else []

    def _judge(self) -> list[Trend]:
        at = np.array([middle for middle, _ in self._means])
        orders = list(self._means[0][1])
        values = np.array([[mean[order] for order in orders] for _, mean in self._means])
        centred = at - at.mean()
        spread = float(centred @ centred)
        slope = centred @ values / spread
        scatter = values - values.mean(axis=0) - np.outer(centred, slope)
        freedom = 2 * (at.size - 2)
        variance = (np.abs(scatter) ** 2).sum(axis=0) / freedom
        ratio = np.abs(slope) ** 2 * spread / (2.0 * np.maximum(variance, np.finfo(float).tiny))
        chance = stats.f.sf(ratio, 2, freedom)
        span = float(at[-1] - at[0])
        found = [
            Trend(
                order,
                float(slope[place].real) * span,
                float(slope[place].imag) * span,
                float(np.sqrt(variance[place] / spread)) * span,
                round(span),
                float(chance[place]),
            )
            for place, order in enumerate(orders)
            if chance[place] < self._false_alarms / len(orders)
            and abs(slope[place]) * span > self._matters_arcsec
        ]
        return sorted(found, key=lambda trend: trend.chance)
