"""Describes the steps in the error of a reference: their instants, sizes and intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from arctrue.base.units import ARCSEC_PER_DEG
from arctrue.workbench.inference.forward.events import ONE_BY_ONE

MANY_ARCSEC = 600.0
"""Smallest angle that is written in degrees."""
LISTED = 6
"""Largest number of jumps that are listed one by one. If there are more, the largest are listed; if
there are more than ONE_BY_ONE, the first."""
FIRST = 3
"""Number of instants in the verdict on more than ONE_BY_ONE jumps."""
LEAST_EVEN, EVEN = 4, 0.05
"""Smallest number of jumps whose intervals are compared, and largest relative difference of an
interval from the median of equal intervals. Three intervals between random instants are equal
within this limit once in 900 records."""
OF_COUNTS = 3.0
"""Largest difference between a jump and a whole number of counts, in standard uncertainties of its
size; a normal value exceeds it with a probability of 0.003."""
BY_CHANCE = 0.05
"""Largest probability that jumps of any size agree with whole counts; with a larger probability,
the agreement is not stated."""


@dataclass(frozen=True)
class Jump:
    """A step in the error of the reference."""

    size_arcsec: float
    sigma_arcsec: float
    """Standard uncertainty of the size."""
    time_s: float | None
    turns: float | None
    """Angle of the jump, in turns, if the rows have no time."""
    row: int | None
    """Row of the file, from 0, that follows the last used row before the jump, for stations without
    times; otherwise None."""
    gain: float
    """Gain in log likelihood by the step."""

    def data(self) -> dict[str, float | int | None]:
        """Return the jump as JSON."""
        return {
            "size_arcsec": self.size_arcsec,
            "sigma_arcsec": self.sigma_arcsec,
            "time_s": self.time_s,
            "turns": self.turns,
            "row": self.row,
        }

    @property
    def where(self) -> str:
        """Return time (or row or angle) of the jump in words."""
        if self.time_s is not None:
            return f"{self.time_s:.5g} s"
        return f"row {self.row}" if self.row is not None else f"{self.turns:.5g} turns"

    @property
    def size(self) -> str:
        """Return the size of the jump and its standard uncertainty in words."""
        return f"{angle_words(self.size_arcsec)} (u {angle_words(self.sigma_arcsec)})"

    def words(self) -> str:
        """Return time (or row or angle) and size of the jump in words."""
        return f"something jumped at {self.where} by {self.size}"


def angle_words(arcsec: float) -> str:
    """Write an angle in arcseconds, or in degrees where it is large."""
    return f"{arcsec:.3g}″" if abs(arcsec) < MANY_ARCSEC else f"{arcsec / ARCSEC_PER_DEG:.3g}°"


def jumps_in_words(jumps: Sequence[Jump], count_arcsec: float | None) -> str:
    """Return all jumps in a few words, for the verdict: a single jump, or their number and the
    largest.

    ``count_arcsec``: size of a count, None if it is unknown.
    """
    if len(jumps) == 1:
        return jumps[0].words() + _counts(jumps, count_arcsec)
    every = interval_s(jumps)
    if len(jumps) > ONE_BY_ONE:
        first = ", ".join(jump.where for jump in sorted(jumps, key=_place)[:FIRST])
        typical = angle_words(float(np.median([abs(jump.size_arcsec) for jump in jumps])))
        return (
            f"something jumped at least {len(jumps)} times, first at {first}; the median size is "
            f"{typical}"
        )
    largest = max(jumps, key=lambda jump: abs(jump.size_arcsec))
    evenly = "" if every is None else f" at equal intervals of {every:.3g} s"
    return (
        f"something jumped {len(jumps)} times{evenly}, farthest at {largest.where} by "
        f"{largest.size}" + _counts(jumps, count_arcsec)
    )


def list_of_jumps(jumps: Sequence[Jump]) -> str:
    """Return a sentence with the instants and sizes of the jumps, at most LISTED of them."""
    if len(jumps) == 1:
        return (
            "The record contains a single event, which no other part of the record can "
            f"confirm: {jumps[0].words()}."
        )
    many = len(jumps) > ONE_BY_ONE
    largest = sorted(jumps, key=_place if many else lambda jump: -abs(jump.size_arcsec))[:LISTED]
    words = "; ".join(f"{jump.size} at {jump.where}" for jump in sorted(largest, key=_place))
    listed = "" if len(jumps) <= LISTED else f"; the {'first' if many else 'largest'} are "
    number = f"at least {len(jumps)}" if many else f"{len(jumps)}"
    return (
        f"The record contains {number} jumps, which no other part of the record can confirm"
        f"{listed or ': '}{words}."
    )


def interval_s(jumps: Sequence[Jump]) -> float | None:
    """Return the interval of jumps at equal intervals, in seconds; None for few jumps and for
    unequal intervals."""
    times = sorted(jump.time_s for jump in jumps if jump.time_s is not None)
    if len(times) < max(LEAST_EVEN, len(jumps)):
        return None
    each = np.diff(times)
    middle = float(np.median(each))
    return middle if float(np.max(np.abs(each - middle))) <= EVEN * middle else None


def whole_counts(jumps: Sequence[Jump], count_arcsec: float | None) -> list[int]:
    """Return the number of counts of each jump; an empty list if the jumps are not whole numbers of
    counts, or could agree with them by chance."""
    if not jumps or not count_arcsec:
        return []
    sizes = np.array([jump.size_arcsec for jump in jumps]) / count_arcsec
    reach = OF_COUNTS * np.array([jump.sigma_arcsec for jump in jumps]) / count_arcsec
    counts = np.round(sizes)
    if np.any(counts == 0.0) or np.any(np.abs(sizes - counts) > reach):
        return []
    if float(np.prod(np.minimum(2.0 * reach, 1.0))) > BY_CHANCE:
        return []
    return [int(count) for count in counts]


def _counts(jumps: Sequence[Jump], count_arcsec: float | None) -> str:
    counts = whole_counts(jumps, count_arcsec)
    if not counts or count_arcsec is None:
        return ""
    ordered = [count for _, count in sorted(zip(map(_place, jumps), counts, strict=True))]
    one = f"a count is {angle_words(count_arcsec)}"
    if len(ordered) == 1:
        return f", a whole number of counts ({ordered[0]}; {one})"
    return f", each by a whole number of counts ({', '.join(map(str, ordered))}; {one})"


def _place(jump: Jump) -> float:
    """Return the place of the jump in the record; all jumps of a record have the same kind of
    place."""
    return float(next(at for at in (jump.time_s, jump.row, jump.turns) if at is not None))
