"""Defines the table's position and the conditions in each row, for sweeps (moving table) and for
stations (standstill)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.floating[Any]]
Integer = NDArray[np.int64]


@dataclass(frozen=True)
class Conditions:
    """Quantities on which a cause may depend; each is an array (rows,)."""

    time_s: Float
    """Time since the start of the session."""
    turned_rad: Float
    """True angle of the table, unwrapped over the session."""
    speed_rad_s: Float
    """Speed with its sign; 0 at standstill."""
    direction: Float
    """Direction of approach to the angle, +1 or −1."""
    warming_k: Float
    """Temperature minus the temperature at which the table has no thermal error."""
    run: Integer
    station: Integer
    """Number of the station; −1 in rows of a moving table."""

    @property
    def rows(self) -> int:
        """Return the number of rows."""
        return self.time_s.size

    def moved(self, by_rad: Float) -> Conditions:
        """Return the same conditions with the table turned by ``by_rad``."""
        return replace(self, turned_rad=self.turned_rad + by_rad)


@dataclass(frozen=True)
class Sweep:
    """Run of a moving table: θ(t) = begin + ω·t + a·t²/2 + ripple, and a temperature that changes
    linearly in time."""

    number: int
    begin_s: float
    begin_rad: float
    speed_rad_s: float
    """Speed with its sign."""
    time_s: Float
    """Times of the rows since the run's start."""
    acceleration_rad_s2: float = 0.0
    ripple_rad: float = 0.0
    ripple_hz: float = 0.0
    warming_k: float = 0.0
    warming_k_s: float = 0.0

    def conditions(self, time_s: Float) -> Conditions:
        """Return the conditions at given times of the run."""
        beat = 2 * np.pi * self.ripple_hz
        turned = self.begin_rad + self.speed_rad_s * time_s
        turned = turned + self.acceleration_rad_s2 * time_s**2 / 2
        turned = turned + self.ripple_rad * np.sin(beat * time_s)
        speed = self.speed_rad_s + self.acceleration_rad_s2 * time_s
        rows = time_s.size
        return Conditions(
            time_s=self.begin_s + time_s,
            turned_rad=turned,
            speed_rad_s=speed + self.ripple_rad * beat * np.cos(beat * time_s),
            direction=np.full(rows, np.sign(self.speed_rad_s)),
            warming_k=self.warming_k + self.warming_k_s * time_s,
            run=np.full(rows, self.number),
            station=np.full(rows, -1),
        )

    @property
    def end_s(self) -> float:
        """Return the session time one step after the last row."""
        return self.begin_s + 2 * float(self.time_s[-1]) - float(self.time_s[-2])

    @property
    def end_rad(self) -> float:
        """Return the table's angle at ``end_s``."""
        last = np.array([self.end_s - self.begin_s])
        return float(self.conditions(last).turned_rad[0])


@dataclass(frozen=True)
class Stations:
    """Visits of stations at standstill, in time order."""

    at: Conditions
    cycle: Integer


def sweeps(
    speeds_rad_s: list[float], rows: int, turns: float, warming_k: list[float] | None = None
) -> list[Sweep]:
    """Make consecutive runs; each starts one minute after the previous run, at the angle where that
    run ended.

    Each run has ``rows`` rows over ``turns`` turns. ``warming_k``: temperature above nominal in
    each run, constant during the run.
    """
    found: list[Sweep] = []
    begin_s, begin_rad = 0.0, 0.1
    for number, speed in enumerate(speeds_rad_s):
        seconds = turns * 2 * np.pi / abs(speed)
        found.append(
            Sweep(
                number,
                begin_s,
                begin_rad,
                speed,
                np.arange(rows) * (seconds / rows),
                warming_k=0.0 if warming_k is None else warming_k[number],
            )
        )
        begin_s, begin_rad = found[-1].end_s + 60.0, found[-1].end_rad
    return found


def stations(
    targets_rad: Float,
    cycles: int,
    both_ways: bool,
    seconds_a_station: float = 5.0,
    begin_s: float = 0.0,
) -> Stations:
    """Make visits of all targets, upwards in every cycle and, with ``both_ways``, also downwards.

    Each pass in one direction counts as a run. The temperature is constant.
    """
    turned: list[Float] = []
    direction: list[Float] = []
    number: list[Integer] = []
    cycle: list[Integer] = []
    run: list[Integer] = []
    for turn in range(cycles):
        for way in (1, -1) if both_ways else (1,):
            order = np.arange(targets_rad.size)[:: 1 if way > 0 else -1]
            # Without ``both_ways`` each cycle continues into the next turn; with ``both_ways`` each
            # cycle returns to its start.
            over = 0.0 if both_ways else 2 * np.pi * turn
            turned.append(targets_rad[order] + over)
            direction.append(np.full(order.size, float(way)))
            number.append(order)
            cycle.append(np.full(order.size, turn))
            run.append(np.full(order.size, len(run)))
    rows = sum(part.size for part in turned)
    at = Conditions(
        time_s=begin_s + seconds_a_station * np.arange(rows),
        turned_rad=np.concatenate(turned),
        speed_rad_s=np.zeros(rows),
        direction=np.concatenate(direction),
        warming_k=np.zeros(rows),
        run=np.concatenate(run),
        station=np.concatenate(number),
    )
    return Stations(at, np.concatenate(cycle))
