"""Computes the temperature of the table over time, and the temperature that a slow sensor shows."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.table.conditions import USUAL_TEMPERATURE_C

Float = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class TemperatureCourse:
    """Temperatures at rising instants; they are linear between the instants and constant before and
    after them.

    Raises ValueError if the instants do not rise, or if instants and temperatures differ in number.
    """

    times_s: tuple[float, ...] = (0.0,)
    temperatures_c: tuple[float, ...] = (USUAL_TEMPERATURE_C,)

    def __post_init__(self) -> None:
        """Raise ValueError for instants that do not rise and for lists of different length."""
        if not self.times_s or len(self.times_s) != len(self.temperatures_c):
            raise ValueError(
                f"a temperature course needs one temperature an instant, found "
                f"{len(self.times_s)} instants and {len(self.temperatures_c)} temperatures"
            )
        if np.any(np.diff(self.times_s) <= 0):
            raise ValueError(f"the instants of a temperature course must rise: {self.times_s}")

    def at(self, time_s: Float) -> Float:
        """Return the temperature at each instant, °C, in the same shape."""
        return np.asarray(np.interp(time_s, self.times_s, self.temperatures_c))

    def lagging(self, time_s: Float, constant_s: float) -> Float:
        """Return the temperature that a first-order sensor with this time constant shows, °C, in
        the same shape.

        The function solves T_s′ = (T − T_s)/τ exactly on each straight piece; before the first
        instant T_s = T.
        """
        times = np.asarray(self.times_s)
        courses = np.asarray(self.temperatures_c)
        # On a piece T = a + b·s the particular solution is a + b·(s − τ); the difference of T_s
        # from this solution decays.
        slopes = np.append(np.diff(courses) / np.diff(times), 0.0)
        shown = np.empty_like(courses)
        shown[0] = courses[0]
        for piece in range(times.size - 1):
            step = times[piece + 1] - times[piece]
            behind = shown[piece] - (courses[piece] - slopes[piece] * constant_s)
            shown[piece + 1] = (
                courses[piece + 1]
                - slopes[piece] * constant_s
                + behind * np.exp(-step / constant_s)
            )
        at = np.clip(np.searchsorted(times, time_s, side="right") - 1, 0, times.size - 1)
        since = np.maximum(time_s - times[at], 0.0)
        particular = courses[at] + slopes[at] * (since - constant_s)
        behind = shown[at] - (courses[at] - slopes[at] * constant_s)
        found = particular + behind * np.exp(-since / constant_s)
        return np.asarray(np.where(time_s < times[0], courses[0], found))
