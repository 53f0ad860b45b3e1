"""How the table is driven: a speed profile with ramps, and a ripple on the angle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.state import TableState


@dataclass(frozen=True, slots=True)
class Motion:
    """A speed that runs straight from knot to knot, and a ripple of the angle on top.

    With the smooth angle s(t), the integral of the profile from ``start_rad``, the true angle is

        θ(t) = s(t) + a·(sin(n·s(t) + p) − sin(n·start + p)),

    so the ripple stands still when the drive does. ``knot_times_s`` begins at 0 and rises;
    ``knot_speeds_rad_s`` has as many values (signed, counter-clockwise positive).
    Raises ValueError for a profile that cannot be driven.
    """

    knot_times_s: tuple[float, ...]
    knot_speeds_rad_s: tuple[float, ...]
    start_rad: float = 0.0
    ripple_rad: float = 0.0
    ripple_order: int = 1
    ripple_phase_rad: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what cannot be driven."""
        times = np.asarray(self.knot_times_s, dtype=np.float64)
        speeds = np.asarray(self.knot_speeds_rad_s, dtype=np.float64)
        if times.size < 2 or times.size != speeds.size:
            raise ValueError(
                f"a motion needs two or more knots with one speed each, "
                f"found {times.size} times and {speeds.size} speeds"
            )
        if times[0] != 0 or not np.all(np.diff(times) > 0):
            raise ValueError(f"knot times must begin at 0 s and rise, found {self.knot_times_s}")
        if not np.all(np.isfinite(times)) or not np.all(np.isfinite(speeds)):
            raise ValueError("knot times and speeds must be finite numbers")
        if abs(self.ripple_rad * self.ripple_order) >= 1:
            raise ValueError(
                f"a ripple of {self.ripple_rad} rad at order {self.ripple_order} would turn the "
                f"table back; |ripple × order| must stay below 1"
            )

    @classmethod
    def steady(
        cls,
        speed_rad_s: float,
        duration_s: float,
        *,
        ramp_s: float = 0.0,
        start_rad: float = 0.0,
        ripple_rad: float = 0.0,
        ripple_order: int = 1,
        ripple_phase_rad: float = 0.0,
    ) -> Motion:
        """One speed for ``duration_s``; with ``ramp_s`` the run-up and run-down lie within it."""
        if ramp_s == 0:
            times: Sequence[float] = (0.0, duration_s)
            speeds: Sequence[float] = (speed_rad_s, speed_rad_s)
        elif 0 < 2 * ramp_s < duration_s:
            times = (0.0, ramp_s, duration_s - ramp_s, duration_s)
            speeds = (0.0, speed_rad_s, speed_rad_s, 0.0)
        else:
            raise ValueError(f"two ramps of {ramp_s} s do not fit into a motion of {duration_s} s")
        return cls(
            tuple(times), tuple(speeds), start_rad, ripple_rad, ripple_order, ripple_phase_rad
        )

    @property
    def duration_s(self) -> float:
        """From the first to the last knot."""
        return self.knot_times_s[-1]

    def turning_times_s(self) -> NDArray[np.float64]:
        """Instants at which the profile bends or changes its sign, rising, shape ``(k,)``.

        Between two neighbours the true angle is monotonic.
        """
        times = np.asarray(self.knot_times_s)
        speeds = np.asarray(self.knot_speeds_rad_s)
        reverses = speeds[:-1] * speeds[1:] < 0
        share = speeds[:-1][reverses] / (speeds[:-1] - speeds[1:])[reverses]
        return np.unique(
            np.concatenate([times, times[:-1][reverses] + share * np.diff(times)[reverses]])
        )

    def state(self, time_s: NDArray[np.float64]) -> TableState:
        """The state at the given instants, shape ``(n,)``.

        Raises ValueError for an instant outside the motion.
        """
        time_s = np.atleast_1d(np.asarray(time_s, dtype=np.float64))
        if time_s.size and (time_s.min() < 0 or time_s.max() > self.duration_s):
            raise ValueError(
                f"the motion lasts from 0 to {self.duration_s} s, "
                f"asked for {time_s.min()} to {time_s.max()} s"
            )
        times = np.asarray(self.knot_times_s)
        speeds = np.asarray(self.knot_speeds_rad_s)
        steps = np.diff(times)
        travelled = np.concatenate([[0.0], np.cumsum(steps * (speeds[:-1] + speeds[1:]) / 2)])
        leg = np.clip(np.searchsorted(times, time_s, side="right") - 1, 0, steps.size - 1)
        since = time_s - times[leg]
        acceleration = (np.diff(speeds) / steps)[leg]
        smooth_speed = speeds[leg] + acceleration * since
        smooth = self.start_rad + travelled[leg] + since * (speeds[leg] + acceleration * since / 2)
        ripple_start = self.ripple_order * self.start_rad + self.ripple_phase_rad
        ripple = self.ripple_order * smooth + self.ripple_phase_rad
        return TableState(
            time_s,
            smooth + self.ripple_rad * (np.sin(ripple) - np.sin(ripple_start)),
            smooth_speed * (1 + self.ripple_rad * self.ripple_order * np.cos(ripple)),
        )
