"""Finds the part of the turn that was measured; the axis of angles shows only this part."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.report.charts.bins import Bins, Integer, of_groups, turn_group
from arctrue.report.charts.chart import Axis, angle_axis

Float = NDArray[np.float64]

WHOLE_DEG = 360.0
_PLACES = 3600
"""Number of places of the turn, 0.1° apart, that are searched for gaps between the rows."""
_ARC_DEG = 180.0
"""Largest gap between rows that cover the whole turn; if a gap is larger, the rows cover an arc,
and the axis shows only this arc."""
_EDGE, _LEAST_SPAN_DEG = 0.03, 0.1
"""Margin at each end of an arc, as a share of the arc; and the span of the axis in degrees if all
rows are at one place."""


@dataclass(frozen=True)
class AngleWindow:
    """The part of the turn that a chart shows: ``span_deg`` from ``start_deg`` on; 360 is the whole
    turn."""

    start_deg: float = 0.0
    span_deg: float = WHOLE_DEG

    @classmethod
    def over(cls, angle_rad: Float) -> AngleWindow:
        """Return the window for angles of shape (rows,): the arc that the rows cover, or the whole
        turn."""
        if not angle_rad.size:
            return cls()
        places = np.unique(turn_group(angle_rad, _PLACES))
        gaps = np.diff(np.append(places, places[0] + _PLACES))
        largest = int(np.argmax(gaps))
        step = WHOLE_DEG / _PLACES
        if gaps[largest] * step <= _ARC_DEG:
            return cls()
        # The window begins in the middle of the largest gap, where there is no row.
        cut = (places[largest] + 0.5 * gaps[largest]) * step
        past = np.mod(np.degrees(angle_rad) - cut, WHOLE_DEG)
        low, high = cut + float(past.min()), cut + float(past.max())
        back = WHOLE_DEG if high > WHOLE_DEG else 0.0
        return cls(low - back, high - low)

    @property
    def is_whole(self) -> bool:
        """Whether the window is the whole turn."""
        return self.span_deg == WHOLE_DEG

    @property
    def end_deg(self) -> float:
        """End of the window, degrees."""
        return self.start_deg + self.span_deg

    def degrees(self, angle_rad: Float) -> Float:
        """Convert angles to places on the axis of the window, degrees."""
        if self.is_whole:
            return np.asarray(np.mod(np.degrees(angle_rad), WHOLE_DEG))
        middle = self.start_deg + 0.5 * self.span_deg - 0.5 * WHOLE_DEG
        return np.asarray(middle + np.mod(np.degrees(angle_rad) - middle, WHOLE_DEG))

    def group(self, angle_rad: Float, bins: int) -> Integer:
        """Return the number of the window's bin for each angle."""
        if self.is_whole:
            return turn_group(angle_rad, bins)
        part = (self.degrees(angle_rad) - self.start_deg) / max(self.span_deg, 1e-12)
        return np.clip((part * bins).astype(np.int64), 0, bins - 1)

    def centres(self, bins: int) -> Float:
        """Return the centres of ``bins`` equal bins of the window, degrees."""
        return np.asarray(self.start_deg + (np.arange(bins) + 0.5) * self.span_deg / bins)

    def bins(self, angle_rad: Float, values: Float, bins: int) -> Bins:
        """Return the means of rows in bins of the angle; in an arc, each mean is drawn at the mean
        angle of its rows."""
        group, centres = self.group(angle_rad, bins), self.centres(bins)
        if not self.is_whole:
            rows = np.maximum(np.bincount(group, minlength=bins), 1)
            centres = np.bincount(group, self.degrees(angle_rad), bins) / rows
        return of_groups(values, group, centres)

    def axis(self, label: str = "angle of the table") -> Axis:
        """Return the axis of the window; the axis of an arc ends near the arc's first and last
        row."""
        if self.is_whole:
            return angle_axis(label)
        edge = max(_EDGE * self.span_deg, _LEAST_SPAN_DEG / 2.0)
        return Axis(label, "deg", reach=(self.start_deg - edge, self.end_deg + edge))
