"""Makes the motion and the temperature of the table in an experiment."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table import HEAD_SEPARATION_RAD, Motion
from arctrue.table.conditions import USUAL_TEMPERATURE_C
from arctrue.table.temperature import TemperatureCourse

TURN_RAD = 2 * np.pi
RUN_UP_RAD = float(np.deg2rad(1.0))


def turning(
    speed_rad_s: float,
    turns: float,
    *,
    ripple_rad: float = 0.0,
    ripple_order: int = 1,
    temperature_c: tuple[float, float] = (USUAL_TEMPERATURE_C, USUAL_TEMPERATURE_C),
    start_s: float = 0.0,
) -> Motion:
    """Return a motion that starts from rest, passes the index of both heads, and makes some turns
    at one signed speed."""
    ahead = HEAD_SEPARATION_RAD + 2 * RUN_UP_RAD
    start_rad = -ahead if speed_rad_s > 0 else 2 * RUN_UP_RAD
    pace = abs(speed_rad_s)
    ramp_s = 2 * RUN_UP_RAD / pace
    duration_s = (ahead + turns * TURN_RAD) / pace + 2 * ramp_s
    return Motion(
        (0.0, ramp_s, duration_s - ramp_s, duration_s),
        (0.0, speed_rad_s, speed_rad_s, 0.0),
        start_rad,
        ripple_rad,
        ripple_order,
        temperature=TemperatureCourse((start_s, start_s + duration_s), temperature_c),
        start_s=start_s,
    )


EACH_SPEED_TURN = 0.1
CHANGE_TURN = 0.4
"""Length of each of the two changes of speed in a turn, in turns. EACH_SPEED_TURN is the length of
the part at each of the two speeds."""


def with_second_speed(drive: Motion, second_rad_s: float) -> Motion:
    """Return ``drive`` over the same angle, rounded up to whole turns, with a part of each turn at
    a second speed.

    Both speeds have the same direction. The ripple of the angle does not change.
    """
    first_rad_s = drive.knot_speeds_rad_s[1]
    ramp_s = drive.knot_times_s[1]
    travel_rad = abs(first_rad_s) * (drive.knot_times_s[2] - ramp_s)
    times, speeds = [0.0, ramp_s], [0.0, first_rad_s]
    rates = (abs(first_rad_s), abs(second_rad_s))
    travelled = 0.0
    while travelled < travel_rad:
        for rate, other in (rates, rates[::-1]):
            times.append(times[-1] + EACH_SPEED_TURN * TURN_RAD / rate)
            speeds.append(float(np.copysign(rate, first_rad_s)))
            times.append(times[-1] + CHANGE_TURN * TURN_RAD / (0.5 * (rate + other)))
            speeds.append(float(np.copysign(other, first_rad_s)))
        travelled += TURN_RAD
    times.append(times[-1] + ramp_s)
    speeds.append(0.0)
    return dataclasses.replace(
        drive,
        knot_times_s=tuple(times),
        knot_speeds_rad_s=tuple(speeds),
    )


def and_back(drive: Motion, turns: float) -> Motion:
    """Return ``drive``, followed by some turns in the opposite direction at the same speed."""
    ramp_s = drive.knot_times_s[1]
    pace = drive.knot_speeds_rad_s[1]
    top_s = drive.knot_times_s[-1]
    steady_s = top_s + ramp_s + turns * TURN_RAD / abs(pace)
    return dataclasses.replace(
        drive,
        knot_times_s=(*drive.knot_times_s, top_s + ramp_s, steady_s, steady_s + ramp_s),
        knot_speeds_rad_s=(*drive.knot_speeds_rad_s, -pace, -pace, 0.0),
    )


_LOOKS_A_TURN = 2000


def times_at(drive: Motion, angles_rad: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return every time of the motion, in seconds, at which the table passes one of the angles."""
    speeds = np.abs(drive.knot_speeds_rad_s)
    looks = int(_LOOKS_A_TURN * speeds.max() * drive.duration_s / TURN_RAD)
    time = np.linspace(0.0, drive.duration_s, looks)
    above = drive.state(time).angle_rad - angles_rad[:, np.newaxis]
    row, at = np.nonzero(np.diff(np.signbit(above), axis=1))
    left, right = above[row, at], above[row, at + 1]
    passed = time[at] + (time[at + 1] - time[at]) * left / (left - right)
    return np.asarray(np.sort(passed))


@dataclass(frozen=True, slots=True)
class StationDrive:
    """Motion that stops at stations, and an instant in each stop; arrays ``(n,)``."""

    drive: Motion
    station_s: NDArray[np.float64]
    """Instant of the motion at which the table stands at each station."""
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
    """Return a motion that passes both indices and then visits every face ``cycles`` times, up and
    back.

    The table stops at each face. A cycle goes one face beyond the last face and returns, then one
    face below the first and returns. In each direction every station is therefore always reached
    from the same side. Before the cycles the table moves up by one face and back; during this time
    the caller can load a correction.
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
    drive = Motion(
        tuple(times),
        tuple(speeds),
        start_rad,
        temperature=TemperatureCourse((0.0,), (temperature_c,)),
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
