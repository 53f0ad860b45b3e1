"""Supplies the readings of the heads as functions of time, counted in clocks of the gateware."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from arctrue.instrument.errors import InstrumentError
from arctrue.table import Motion, RotaryTable
from arctrue.table.cause import SIGNALS, refuse_unhonoured

INTERPOLATION_TOLERANCE_COUNTS = 1e-3
"""Largest permitted difference between the cubic interpolation and the exact geometry, counts; it
is checked in every piece."""
_MOST_COUNTS_A_KNOT = 16.0
_MOST_KNOT_CLOCKS = 4096
_CHECKED_CLOCKS = 64

Curve = NDArray[np.float64]


class Curves(Protocol):
    """Interface that gives the readings of the heads and the true angle in order of time."""

    counts_per_rev: int
    index_width_counts: int
    rounding_counts: float
    """Value added to a reading before it is rounded down: 0 or 0.5."""
    clocks: int
    """Length of the curves in clocks; afterwards the pins keep their last levels."""

    def piece(self, first_clock: int, clocks: int) -> tuple[int, *tuple[Curve, ...]]:
        """Return the values at the knots of one piece.

        Parameters
        ----------
        first_clock : int
            Clocks from the start of the curves to the beginning of the piece.
        clocks : int
            Length of the piece, clocks; the last interval of knots may end before or after the
            piece.

        Returns
        -------
        tuple
            The clocks between two knots; the readings of each head, counts from its index; the true
            angle of the table, radians, not wrapped. Arrays of shape (n + 3,): the knots −1, 0, …,
            n + 1.
        """


class TableCurves:
    """Computes the exact geometry of a moving table at knots.

    The instrument interpolates between knots with a cubic. The distance of the knots is halved
    while the cubic deviates from the geometry by more than INTERPOLATION_TOLERANCE_COUNTS at one of
    64 random clocks of a piece. At a distance of one clock the result is exact.

    Parameters
    ----------
    table : RotaryTable
        The table with its causes.
    motion : Motion
        Its motion.
    clock_hz : float
        Number of clocks in a second of the table's time.
    knot_clocks : int, optional
        Number of clocks between two knots; by default the largest power of two, up to 4096, in
        which the table travels at most 16 counts.
    """

    def __init__(
        self,
        table: RotaryTable,
        motion: Motion,
        clock_hz: float,
        knot_clocks: int | None = None,
    ) -> None:
        """Store a table and its motion.

        Raises UnhonouredCauseError for a cause that acts on a quantity other than the lines and
        their signals, for example a loss of counts: :class:`PinFault` simulates it.
        """
        refuse_unhonoured(table.causes, SIGNALS, "the virtual instrument")
        self.table, self.motion, self.clock_hz = table, motion, clock_hz
        self.counts_per_rev = table.counts_per_rev
        self.index_width_counts = table.index_width_counts
        self.rounding_counts = 0.5 if table.rounding == "nearest" else 0.0
        self._knot = knot_clocks or self._first_knot_clocks()
        self.clocks = int(motion.duration_s * clock_hz)
        if self.clocks < 1:
            raise InstrumentError(
                f"a motion of {motion.duration_s} s is less than one clock of {clock_hz:g} Hz"
            )

    def _first_knot_clocks(self) -> int:
        fastest = max(abs(speed) for speed in self.motion.knot_speeds_rad_s)
        fastest *= 1 + abs(self.motion.ripple_rad * self.motion.ripple_order)
        counts_a_clock = fastest / self.table.count_rad / self.clock_hz
        knot = 1
        while knot < _MOST_KNOT_CLOCKS and 2 * knot * counts_a_clock <= _MOST_COUNTS_A_KNOT:
            knot *= 2
        return knot

    def _at(self, clock: NDArray[np.int64]) -> tuple[Curve, ...]:
        time_s = np.clip(clock / self.clock_hz, 0.0, self.motion.duration_s)
        state = self.motion.state(time_s)
        heads = range(len(self.table.heads))
        readings = (self.table.reading_rad(head, state) / self.table.count_rad for head in heads)
        return (*readings, state.angle_rad)

    def piece(self, first_clock: int, clocks: int) -> tuple[int, *tuple[Curve, ...]]:
        """Return the values at the knots of one piece, as :meth:`Curves.piece` describes.

        Parameters
        ----------
        first_clock : int
            Clocks from the start of the motion to the beginning of the piece.
        clocks : int
            Length of the piece, clocks.

        Returns
        -------
        tuple
            The clocks between two knots, the readings of each head, and the true angle, (n + 3,).
        """
        while True:
            knot = self._knot
            intervals = max(1, -(-min(clocks, self.clocks - first_clock) // knot))
            at = first_clock + knot * np.arange(-1, intervals + 2, dtype=np.int64)
            inside = (at >= 0) & (at <= self.clocks)
            begin, end = int(np.argmax(inside)), at.size - int(np.argmax(inside[::-1]))
            curves = [_extended(values, begin, at.size) for values in self._at(at[begin:end])]
            if knot == 1 or self._fits(first_clock, intervals, *curves[:-1]):
                return (knot, *curves)
            self._knot = knot // 2

    def _fits(self, first_clock: int, intervals: int, *curves: Curve) -> bool:
        """Tell whether the cubic agrees with the geometry at random clocks between the knots."""
        random = np.random.default_rng(first_clock)
        interval = random.integers(0, intervals, _CHECKED_CLOCKS)
        share = random.integers(1, self._knot, _CHECKED_CLOCKS) / self._knot
        clock = first_clock + np.rint((interval + share) * self._knot).astype(np.int64)
        known = clock <= self.clocks
        interval, share = interval[known], share[known]
        exact = self._at(clock[known])
        return all(
            float(np.max(np.abs(_cubic(curve, interval, share) - value), initial=0.0))
            <= INTERPOLATION_TOLERANCE_COUNTS
            for curve, value in zip(curves, exact[: len(curves)], strict=True)
        )


def _extended(values: Curve, before: int, number: int) -> Curve:
    """Extend ``values`` along straight lines by ``before`` values at the start, and to ``number``
    values in total."""
    made = np.empty(number)
    end = before + values.size
    made[before:end] = values
    slope_first = values[1] - values[0] if values.size > 1 else 0.0
    slope_last = values[-1] - values[-2] if values.size > 1 else 0.0
    made[:before] = values[0] + slope_first * np.arange(-before, 0)
    made[end:] = values[-1] + slope_last * np.arange(1, number - end + 1)
    return made


def _cubic(curve: Curve, interval: NDArray[np.int64], share: Curve) -> Curve:
    """Evaluate Lagrange's cubic through four knots, with another formula than the harness."""
    result = np.zeros_like(share)
    places = (-1, 0, 1, 2)
    for place in places:
        weight = np.ones_like(share)
        for other in places:
            if other != place:
                weight *= (share - other) / (place - other)
        result += weight * curve[interval + 1 + place]
    return result
