"""Computes the course of the table: the motion over its legs, one after the other, with the time of
the motion and the time of the surroundings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table import HEAD_SEPARATION_RAD, Motion

TURN_RAD = 2 * np.pi
RUN_UP_RAD = float(np.deg2rad(1.0))
"""Travel, in radians, in which the table accelerates from rest to its speed."""
APPROACH_RAD = HEAD_SEPARATION_RAD + 3 * RUN_UP_RAD
"""Travel, in radians, before the first turn; within this travel the table passes both indices."""
_LAST_STAND_S = 0.1
_SAME_TRAVEL_RAD = 1e-9

Float = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Leg:
    """Part of the course: turns at one speed, or a pause."""

    turns: float = 0.0
    """Number of turns with the sign of the direction; 0 for a pause."""
    speed_rad_s: float = 0.0
    """Speed without its sign."""
    pause_s: float = 0.0
    """Duration of the pause in the time of the surroundings, in which table and surroundings change
    temperature."""
    run_s: float = 0.0
    """Part of the pause that is simulated clock by clock; the simulation skips the remainder."""


@dataclass(frozen=True, slots=True)
class Course(Motion):
    """Motion over legs; turns count from the angle after both indices.

    ``time_s`` of its states is the time of the motion, in which a pause lasts as long as its
    simulated part; ``since_run_start_s`` is the time of the surroundings, in which the pause has
    its whole duration.
    """

    @classmethod
    def over(
        cls,
        legs: Sequence[Leg],
        *,
        ripple_rad: float = 0.0,
        ripple_order: int = 1,
    ) -> Course:
        """Return a course that starts from rest, passes both indices, and then runs the legs, each
        from rest to rest.

        Travel 0 is the angle after the indices. Raises ValueError if the first leg is a pause, or
        if a leg is too short for its ramps.
        """
        if not legs or not legs[0].turns:
            raise ValueError("the first leg must turn the table: both heads need their index")
        forward = legs[0].turns > 0
        times, speeds, around = [0.0], [0.0], [0.0]

        def go_on(seconds: float, speed: float, surroundings: float) -> None:
            times.append(times[-1] + seconds)
            speeds.append(speed)
            around.append(around[-1] + surroundings)

        ahead = APPROACH_RAD
        for leg in legs:
            if not leg.turns:
                go_on(leg.run_s, 0.0, leg.pause_s)
                continue
            travel = ahead + abs(leg.turns) * TURN_RAD
            ahead = 0.0
            speed = float(np.copysign(leg.speed_rad_s, leg.turns))
            ramp_s = 2 * RUN_UP_RAD / leg.speed_rad_s
            steady_s = (travel - 2 * RUN_UP_RAD) / leg.speed_rad_s
            if steady_s <= 0:
                raise ValueError(f"{leg.turns:g} turns are too few for a run-up and a run-down")
            go_on(ramp_s, speed, ramp_s)
            go_on(steady_s, speed, steady_s)
            go_on(ramp_s, 0.0, ramp_s)
        go_on(_LAST_STAND_S, 0.0, _LAST_STAND_S)
        start = -HEAD_SEPARATION_RAD - 2 * RUN_UP_RAD if forward else 2 * RUN_UP_RAD
        return cls(
            tuple(times),
            tuple(speeds),
            start,
            ripple_rad,
            ripple_order,
            surroundings_s=tuple(around),
        )

    @property
    def turns(self) -> float:
        """Return the travel from the beginning of the first turn to the end of the course, in
        turns; both directions count as positive."""
        return float(self.travel_turns(np.array([self.duration_s]))[0])

    def travel_turns(self, time_s: Float) -> Float:
        """Return the travel, in turns, at instants of the motion; it is negative before the indices
        are passed."""
        return np.asarray((self.travel_rad(time_s) - APPROACH_RAD) / TURN_RAD)

    def time_at_turn(self, turn: float) -> float:
        """Return the first instant of the motion at which the table has travelled this number of
        turns."""
        travelled = self.travel_rad(np.asarray(self.knot_times_s))
        wanted = turn * TURN_RAD + APPROACH_RAD
        # At a pause choose the instant before the pause, even if two equal sums differ in their
        # last bit.
        place = np.searchsorted(travelled, wanted - _SAME_TRAVEL_RAD) - 1
        leg = int(np.clip(place, 0, travelled.size - 2))
        begin, end = np.abs(self.knot_speeds_rad_s[leg : leg + 2])
        seconds = self.knot_times_s[leg + 1] - self.knot_times_s[leg]
        rest = min(wanted, travelled[-1]) - travelled[leg]
        root = np.sqrt(max(0.0, begin**2 + 2 * (end - begin) / seconds * rest))
        since = 0.0 if begin + root == 0 else 2 * rest / (begin + root)
        return float(self.knot_times_s[leg] + min(since, seconds))
