"""Computes the motion of the table: a speed profile with ramps, pauses and reversals, and a ripple
of the angle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from arctrue.table.conditions import Conditions
from arctrue.table.temperature import TemperatureCourse


@dataclass(frozen=True, slots=True)
class Motion:
    """A motion whose speed is linear between knots, with a ripple of the angle.

    The smooth angle s(t) is ``start_rad`` plus the integral of the profile. The true angle is θ(t)
    = s(t) + a·(sin(n·s(t) + p) − sin(n·start + p)), so the ripple does not change while the drive
    stands still. ``knot_times_s`` begins at 0 and rises; ``knot_speeds_rad_s`` has the same number
    of values (signed, counter-clockwise positive). A motion begins as if the table had just
    reversed. Raises ValueError for a profile that cannot be driven.
    """

    knot_times_s: tuple[float, ...]
    """Times of the knots, seconds, rising from 0."""
    knot_speeds_rad_s: tuple[float, ...]
    """Speed at each knot, radians a second, counter-clockwise positive."""
    start_rad: float = 0.0
    """True angle at the beginning, radians."""
    ripple_rad: float = 0.0
    """Amplitude a of the ripple, radians."""
    ripple_order: int = 1
    """Number n of ripple periods a turn."""
    ripple_phase_rad: float = 0.0
    """Phase p of the ripple, radians."""
    temperature: TemperatureCourse = field(default_factory=TemperatureCourse)
    """Temperature as a function of the time of the surroundings; the motion begins at
    ``start_s``."""
    surroundings_s: tuple[float, ...] | None = None
    """Time of the surroundings at each knot. This time includes pauses in full, even if the motion
    contains only a part of a pause. None: it equals the time of the motion."""
    start_s: float = 0.0
    """Time of the measurement at which the motion begins, seconds."""
    run: int = 0
    """Number of the run within the measurement."""
    travelled_rad: float = 0.0
    """Travel of the table before the motion, summed over both directions."""

    def __post_init__(self) -> None:
        """Raise ValueError for a profile that cannot be driven."""
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
        if self.surroundings_s is not None and len(self.surroundings_s) != times.size:
            raise ValueError(
                f"the surroundings need one time a knot, found {len(self.surroundings_s)} for "
                f"{times.size} knots"
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
    ) -> Motion:
        """Return a motion at one speed, with optional ramps.

        Parameters
        ----------
        speed_rad_s : float
            The speed, radians a second, counter-clockwise positive.
        duration_s : float
            Time of the whole motion, seconds.
        ramp_s : float
            Time of the run-up and of the run-down within the duration, seconds; 0: none.
        start_rad : float
            True angle at the beginning, radians.
        ripple_rad : float
            Amplitude of the ripple of the angle, radians.
        ripple_order : int
            Number of ripple periods a turn.

        Returns
        -------
        Motion
            The motion.

        Raises
        ------
        ValueError
            If both ramps do not fit into the duration, or the motion cannot be driven.
        """
        if ramp_s == 0:
            times: Sequence[float] = (0.0, duration_s)
            speeds: Sequence[float] = (speed_rad_s, speed_rad_s)
        elif 0 < 2 * ramp_s < duration_s:
            times = (0.0, ramp_s, duration_s - ramp_s, duration_s)
            speeds = (0.0, speed_rad_s, speed_rad_s, 0.0)
        else:
            raise ValueError(f"two ramps of {ramp_s} s do not fit into a motion of {duration_s} s")
        return cls(tuple(times), tuple(speeds), start_rad, ripple_rad, ripple_order)

    @property
    def duration_s(self) -> float:
        """Time from the first knot to the last knot."""
        return self.knot_times_s[-1]

    def turning_times_s(self) -> NDArray[np.float64]:
        """Return the instants at which the speed profile bends or changes its sign.

        Between two neighbouring instants the true angle is monotonic.

        Returns
        -------
        ndarray
            Rising times, seconds, shape (k,).
        """
        times = np.asarray(self.knot_times_s)
        speeds = np.asarray(self.knot_speeds_rad_s)
        reverses = speeds[:-1] * speeds[1:] < 0
        share = speeds[:-1][reverses] / (speeds[:-1] - speeds[1:])[reverses]
        return np.unique(
            np.concatenate([times, times[:-1][reverses] + share * np.diff(times)[reverses]])
        )

    def surroundings_at(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the time of the surroundings since the motion began.

        Parameters
        ----------
        time_s : ndarray
            Instants since the motion began, seconds, shape (n,).

        Returns
        -------
        ndarray
            Time, seconds, shape (n,); longer than the time of the motion after a shortened pause.
        """
        if self.surroundings_s is None:
            return np.asarray(time_s, dtype=np.float64)
        return np.asarray(np.interp(time_s, self.knot_times_s, self.surroundings_s))

    def temperature_c(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the temperature during the motion.

        Parameters
        ----------
        time_s : ndarray
            Instants since the motion began, seconds, shape (n,).

        Returns
        -------
        ndarray
            Temperature, °C, shape (n,).
        """
        return self.temperature.at(self.start_s + self.surroundings_at(time_s))

    def travel_rad(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the travel in both directions since the motion began.

        Parameters
        ----------
        time_s : ndarray
            Instants since the motion began, seconds, shape (n,).

        Returns
        -------
        ndarray
            Travel, radians, shape (n,).
        """
        return _travel_of(self.knot_times_s, self.knot_speeds_rad_s).at(time_s)[1]

    def state(self, time_s: NDArray[np.float64]) -> Conditions:
        """Return the state of the table and its conditions.

        Parameters
        ----------
        time_s : ndarray
            Instants since the motion began, seconds, shape (n,).

        Returns
        -------
        Conditions
            Angle, speed, temperature, direction and travel, each of shape (n,).

        Raises
        ------
        ValueError
            If an instant is outside the motion.
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
        course = _travel_of(self.knot_times_s, self.knot_speeds_rad_s)
        piece, travel = course.at(time_s)
        return Conditions(
            self.start_s + time_s,
            smooth + self.ripple_rad * (np.sin(ripple) - np.sin(ripple_start)),
            smooth_speed * (1 + self.ripple_rad * self.ripple_order * np.cos(ripple)),
            self.temperature_c(time_s),
            course.side[piece],
            np.full(time_s.shape, self.run, dtype=np.int64),
            self.surroundings_at(time_s),
            self.travelled_rad + travel,
            travel - course.turned_back_rad[piece],
        )


@dataclass(frozen=True, slots=True)
class _Travel:
    """A speed profile that is divided into pieces of one direction each: ``k`` instants and speeds,
    ``k − 1`` pieces."""

    times_s: NDArray[np.float64]
    speeds_rad_s: NDArray[np.float64]
    travelled_rad: NDArray[np.float64]
    """Travel in both directions until each instant."""
    side: NDArray[np.float64]
    """Direction of each piece, +1 or −1; a table at rest keeps the direction of its last motion;
    before its first motion it has the direction of that motion; 0 if it never moves.
    """
    turned_back_rad: NDArray[np.float64]
    """Travel at the last reversal before each piece."""

    def at(self, time_s: NDArray[np.float64]) -> tuple[NDArray[np.intp], NDArray[np.float64]]:
        """Return the piece that contains each instant, and the travel until this instant, in the
        same shape."""
        piece = np.clip(
            np.searchsorted(self.times_s, time_s, side="right") - 1, 0, self.side.size - 1
        )
        since = np.minimum(time_s, self.times_s[-1]) - self.times_s[piece]
        acceleration = (np.diff(self.speeds_rad_s) / np.diff(self.times_s))[piece]
        gone = since * (self.speeds_rad_s[piece] + acceleration * since / 2)
        return piece, self.travelled_rad[piece] + np.abs(gone)


@lru_cache(maxsize=64)
def _travel_of(knot_times_s: tuple[float, ...], knot_speeds_rad_s: tuple[float, ...]) -> _Travel:
    times = Motion(knot_times_s, knot_speeds_rad_s).turning_times_s()
    speeds = np.interp(times, knot_times_s, knot_speeds_rad_s)
    middle = (speeds[:-1] + speeds[1:]) / 2
    gone = np.abs(middle) * np.diff(times)
    travelled = np.concatenate([[0.0], np.cumsum(gone)])
    moving = np.flatnonzero(middle)
    side = np.zeros(middle.size)
    turned_back = np.zeros(middle.size)
    if moving.size:
        last = np.maximum(np.searchsorted(moving, np.arange(middle.size), side="right") - 1, 0)
        side = np.sign(middle[moving[last]])
        reversed_here = np.diff(side, prepend=side[0]) != 0
        begins = np.where(reversed_here, travelled[:-1], 0.0)
        turned_back = np.maximum.accumulate(begins)
    return _Travel(times, speeds, travelled, side, turned_back)
