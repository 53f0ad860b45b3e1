"""Compares the means of the runs of a reference at each speed, up and down.

An error of motion (a delay, a reversal error, drag) changes its sign with the direction. The part
of the run means that does not change its sign is the noise of the comparison.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from arctrue.workbench.observations import ReferenceRows

Float = NDArray[np.float64]

SURE_P = 1e-4
"""Largest p of a sure result; it equals the limit for a lack of fit."""
LEAST_SPEEDS = 4
"""Fewest speeds: a reversal error and a delay describe any error at two speeds, and with three
speeds a single speed would decide."""
LEAST_FREE = 3
"""Fewest degrees of freedom of the run means that the constant and the speeds must leave."""
SAME_SPEED = 0.02
"""Largest relative difference of two speeds that count as the same; a drive repeats a set speed
within a few per mille."""
STANDS = 1e-3
"""A run stands still if it is slower than this share of the fastest run. A delay then causes less
than this share of its largest error, which no run mean shows."""
ONE_WAY = 0.5
"""A run moves one way if the magnitude of its mean speed is at least this share of its mean
absolute speed. A run that goes there and back has no direction of its own."""
MOST_UNEXPLAINED = 0.1
"""Largest share of the squares of the run means that the speeds may leave unexplained; with a
larger share, the means do not follow the speeds."""


@dataclass(frozen=True, eq=False)
class SpeedLevels:
    """Means of the runs, and their part at each speed that changes its sign with the direction."""

    speed_rad_s: Float
    means: Float
    level: NDArray[np.int64]
    """Number of the speed of each run, the slowest first."""
    moving: NDArray[np.bool_]
    """True for the runs of the set that move one way, shape (runs of the set,). The other fields
    contain these runs only."""

    @property
    def columns(self) -> Float:
        """The constant and one column for each speed, with the sign of the direction."""
        there = self.level[:, np.newaxis] == np.arange(self.number)
        return np.hstack(
            [np.ones((self.means.size, 1)), np.sign(self.speed_rad_s)[:, None] * there]
        )

    @property
    def number(self) -> int:
        """Number of speeds."""
        return int(self.level.max()) + 1

    @property
    def free(self) -> int:
        """Degrees of freedom that the constant and the speeds leave."""
        return self.means.size - 1 - self.number

    def left(self, columns: Float) -> float:
        """Return the sum of squares of the means that columns leave."""
        found = self.means - columns @ np.linalg.lstsq(columns, self.means, rcond=None)[0]
        return float(found @ found)

    def follow_the_speed(self) -> bool:
        """Tell whether the speeds, up and down, describe the means of the runs."""
        before, after = self.left(np.ones((self.means.size, 1))), self.left(self.columns)
        if after > MOST_UNEXPLAINED * before:
            return False
        ratio = (before - after) / self.number / max(after / self.free, 1e-300)
        return float(fdtrc(self.number, self.free, ratio)) < SURE_P

    def words(self) -> str:
        """Return the part of the means that changes its sign with the direction, by speed."""
        halves = np.linalg.lstsq(self.columns, self.means, rcond=None)[0][1:]
        size_deg_s = np.degrees(np.abs(self.speed_rad_s))
        speeds = [float(size_deg_s[self.level == number].mean()) for number in range(self.number)]
        smallest = 0.01 * float(np.abs(halves).max(initial=0.0))
        listed = (f"{0.0 if abs(value) < smallest else value:.2g}″" for value in halves)
        at = ", ".join(f"{value:.3g}" for value in speeds)
        return f"±({', '.join(listed).replace('-', '−')}) at {at}°/s up and down"


def of_runs(rows: ReferenceRows, values: Float) -> Float:
    """Return the mean of ``values``, (rows,), over each run."""
    pieces = np.split(values, np.flatnonzero(np.diff(rows.run) != 0) + 1)
    return np.array([piece.mean() for piece in pieces])


def speed_levels(
    rows: ReferenceRows, left: Float, least_speeds: int = LEAST_SPEEDS
) -> SpeedLevels | None:
    """Return the means of the runs by speed; None with fewer than ``least_speeds`` speeds, with too
    few runs, or if no speed occurs in both directions.

    Runs that stand still, runs that go there and back, and runs at a speed that occurs in one
    direction only are left out: an offset of a single run would look like an error of its speed.
    """
    if rows.speed_rad_s is None:
        return None
    mean, size = of_runs(rows, rows.speed_rad_s), of_runs(rows, np.abs(rows.speed_rad_s))
    moving = (size > STANDS * size.max()) & (np.abs(mean) >= ONE_WAY * size)
    speed, means = mean[moving], of_runs(rows, left)[moving]
    size = np.abs(speed)
    order = np.argsort(size)
    new = np.diff(size[order], prepend=-1.0) > SAME_SPEED * size[order]
    level = np.empty(size.size, dtype=np.int64)
    level[order] = np.cumsum(new) - 1
    both = np.isin(level, np.intersect1d(level[speed > 0.0], level[speed < 0.0]))
    if not both.any():
        return None
    moving[moving] = both
    level = np.unique(level[both], return_inverse=True)[1]
    found = SpeedLevels(speed[both], means[both], level, moving)
    return found if found.number >= least_speeds and found.free >= LEAST_FREE else None
