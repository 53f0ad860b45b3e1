"""How the table is driven, and how warm it is meanwhile."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table import HEAD_SEPARATION_RAD, Motion
from arctrue.table.conditions import USUAL_TEMPERATURE_C, Conditions
from arctrue.table.temperature import TemperatureCourse

TURN_RAD = 2 * np.pi
RUN_UP_RAD = float(np.deg2rad(1.0))
REVERSAL_SHARE = 0.25
"""Part of a leg over which friction changes its sides after a reversal."""


@dataclass(frozen=True, slots=True)
class Drive(Motion):
    """A motion with the temperature of the table, and the side from which each angle is reached."""

    first_temperature_c: float = USUAL_TEMPERATURE_C
    last_temperature_c: float = USUAL_TEMPERATURE_C
    """Straight in between."""
    start_s: float = 0.0
    """Time of the measurement at which the motion begins."""

    def state(self, time_s: NDArray[np.float64]) -> Conditions:
        """The state with its conditions at the given instants of the motion, shape ``(n,)``."""
        state = Motion.state(self, time_s)
        return Conditions(
            self.start_s + state.time_s,
            state.angle_rad,
            state.speed_rad_s,
            self.temperature_c(state.time_s),
            self._direction(state.time_s),
            np.zeros(state.time_s.size, dtype=np.int64),
            state.time_s,
        )

    def temperature_c(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Temperature at instants of the motion, shape ``(n,)``."""
        share = time_s / self.duration_s
        warmed = share * (self.last_temperature_c - self.first_temperature_c)
        return np.asarray(self.first_temperature_c + warmed)

    def shown_c(self, time_s: NDArray[np.float64], lag_s: float) -> NDArray[np.float64]:
        """What a sensor shows that lags with this time constant, shape ``(n,)``."""
        if lag_s == 0.0:
            return self.temperature_c(time_s)
        course = TemperatureCourse(
            (0.0, self.duration_s), (self.first_temperature_c, self.last_temperature_c)
        )
        return course.lagging(time_s, lag_s)

    def _direction(self, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
        speeds = np.asarray(self.knot_speeds_rad_s)
        sides = np.sign(speeds[:-1] + speeds[1:])
        first = sides[np.flatnonzero(sides)[0]] if sides.any() else 0.0
        times, values = [0.0], [first]
        for begin, end, side in zip(
            self.knot_times_s[:-1], self.knot_times_s[1:], sides, strict=True
        ):
            # A table that stands still keeps the side from which it came.
            held = side if side else values[-1]
            times += [begin + REVERSAL_SHARE * (end - begin), end]
            values += [held, held]
        return np.asarray(np.interp(time_s, times, values), dtype=np.float64)


def turning(
    speed_rad_s: float,
    turns: float,
    *,
    ripple_rad: float = 0.0,
    ripple_order: int = 1,
    temperature_c: tuple[float, float] = (USUAL_TEMPERATURE_C, USUAL_TEMPERATURE_C),
    start_s: float = 0.0,
) -> Drive:
    """From rest over the index of both heads, then so many turns at one speed of either sign."""
    ahead = HEAD_SEPARATION_RAD + 2 * RUN_UP_RAD
    start_rad = -ahead if speed_rad_s > 0 else 2 * RUN_UP_RAD
    pace = abs(speed_rad_s)
    ramp_s = 2 * RUN_UP_RAD / pace
    duration_s = (ahead + turns * TURN_RAD) / pace + 2 * ramp_s
    return Drive(
        (0.0, ramp_s, duration_s - ramp_s, duration_s),
        (0.0, speed_rad_s, speed_rad_s, 0.0),
        start_rad,
        ripple_rad,
        ripple_order,
        first_temperature_c=temperature_c[0],
        last_temperature_c=temperature_c[1],
        start_s=start_s,
    )


@dataclass(frozen=True, slots=True)
class StationDrive:
    """A drive that stops at stations, and when it stands at each; arrays ``(n,)``."""

    drive: Drive
    station_s: NDArray[np.float64]
    """An instant of the motion at which the table stands."""
    target_deg: NDArray[np.float64]
    direction: NDArray[np.int64]
    cycle: NDArray[np.int64]


def over_stations(
    speed_rad_s: float,
    faces: int,
    cycles: int,
    *,
    stop_s: float,
    temperature_c: float = USUAL_TEMPERATURE_C,
    start_s: float = 0.0,
) -> StationDrive:
    """Over both indices, then ``cycles`` times up to every face and back, with a stop at each.

    A cycle goes a face further than the last one, and a face lower than the first, and returns
    to it, so that every station is reached from its side. Before them the table goes a face up and
    back, in which time a correction can be switched on.
    """
    step_rad = TURN_RAD / faces
    up = np.arange(faces)
    numbers: list[int] = [1, -1]
    sides: list[int] = [0, 0]
    for _ in range(cycles):
        numbers += [*up.tolist(), faces, *up[::-1].tolist(), -1]
        sides += [*([1] * faces), 0, *([-1] * faces), 0]
    start_rad = -HEAD_SEPARATION_RAD - 2 * RUN_UP_RAD
    times, speeds, at = [0.0], [0.0], start_rad
    standing: list[float] = []
    ramp_s = RUN_UP_RAD / speed_rad_s
    for number in numbers:
        travel = number * step_rad - at
        pace = float(np.copysign(speed_rad_s, travel))
        leg_s = abs(travel) / speed_rad_s + ramp_s
        begin = times[-1]
        times += [begin + ramp_s, begin + leg_s - ramp_s, begin + leg_s, begin + leg_s + stop_s]
        speeds += [pace, pace, 0.0, 0.0]
        at += pace * (leg_s - ramp_s)
        standing.append(begin + leg_s + 0.75 * stop_s)
    kept = np.flatnonzero(sides)
    drive = Drive(
        tuple(times),
        tuple(speeds),
        start_rad,
        first_temperature_c=temperature_c,
        last_temperature_c=temperature_c,
        start_s=start_s,
    )
    return StationDrive(
        drive,
        _taken(standing, kept),
        _taken(numbers, kept) * (360.0 / faces),
        np.asarray(sides, dtype=np.int64)[kept],
        (kept - 2) // (2 * faces + 2),
    )


def _taken(values: Sequence[float], kept: NDArray[np.intp]) -> NDArray[np.float64]:
    return np.asarray(values, dtype=np.float64)[kept]
