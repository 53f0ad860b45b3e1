"""Holds the parameters from which the firmware computes the amplitudes and phases of lanes that
follow the temperature."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.generated.number_formats import THERMAL_RANGE_K

SLOPE_LSB_COUNTS = 2.0**-20
"""Unit of a slope's word: counts per kelvin, or counts per kelvin squared."""
SLOPE_WORD_MAX = 2**31 - 1
ORDERS_MOST = 16
"""Largest number of orders that follow the temperature in the firmware."""
TIME_CONSTANT_MOST_S = 3600.0


@dataclass(frozen=True, eq=False)
class ThermalLanes:
    """Cosine and sine of some orders as c₀ + c₁·(T − T₀) + c₂·(T − T₀)², where c₀ is the value that
    the lane has at T₀ (``reference_c``).

    ``orders`` (n,); ``slopes`` (n, 4), int64 words of 2⁻²⁰ count: cosine and sine per kelvin,
    cosine and sine per kelvin squared. ``time_constant_s``: time constant of the thermometer's
    first-order lag. Below ``least_c`` and above ``most_c`` the lanes keep their values at these
    limits; NaN: the limit is THERMAL_RANGE_K away from T₀. Temperatures and time are rounded to
    thousandths, as the device stores them. Raises ValueError for values that the firmware cannot
    hold.
    """

    orders: tuple[int, ...]
    slopes: NDArray[np.int64]
    reference_c: float
    time_constant_s: float = 0.0
    least_c: float = math.nan
    most_c: float = math.nan

    def __post_init__(self) -> None:
        """Check the words, and make the array read-only. Raises ValueError for a word that does not
        fit."""
        if not 1 <= len(self.orders) <= ORDERS_MOST or len(set(self.orders)) != len(self.orders):
            raise ValueError(
                f"orders that follow the temperature: 1 to {ORDERS_MOST}, each once, found "
                f"{list(self.orders)}"
            )
        slopes = np.asarray(self.slopes)
        if slopes.shape != (len(self.orders), 4):
            raise ValueError(f"slopes: expected four words per order, found shape {slopes.shape}")
        if np.abs(slopes).max() > SLOPE_WORD_MAX:
            raise ValueError(f"slopes: a word is beyond ±{SLOPE_WORD_MAX}")
        if not -273.15 <= self.reference_c <= 1000.0:
            raise ValueError(f"reference_c: {self.reference_c}, expected -273.15 to 1000")
        if not 0.0 <= self.time_constant_s <= TIME_CONSTANT_MOST_S:
            raise ValueError(
                f"sensor_time_constant_s: {self.time_constant_s}, expected 0 to "
                f"{TIME_CONSTANT_MOST_S:g}"
            )
        slopes = slopes.astype(np.int64)
        slopes.flags.writeable = False
        object.__setattr__(self, "slopes", slopes)
        object.__setattr__(self, "reference_c", round(self.reference_c, 3))
        object.__setattr__(self, "time_constant_s", round(self.time_constant_s, 3))
        for name, side in (("least_c", -1), ("most_c", 1)):
            limit = getattr(self, name)
            if math.isnan(limit):
                limit = self.reference_c + side * THERMAL_RANGE_K
            object.__setattr__(self, name, round(min(max(limit, -273.15), 1000.0), 3))
        if not self.least_c <= self.reference_c <= self.most_c:
            raise ValueError(
                f"least_c, most_c: {self.least_c:g} to {self.most_c:g}, expected a range that "
                f"holds reference_c, {self.reference_c:g}"
            )

    def __eq__(self, other: object) -> bool:
        """Tell whether all words of both objects are equal."""
        if not isinstance(other, ThermalLanes):
            return NotImplemented
        return (
            self.orders == other.orders
            and np.array_equal(self.slopes, other.slopes)
            and self.reference_c == other.reference_c
            and self.time_constant_s == other.time_constant_s
            and (self.least_c, self.most_c) == (other.least_c, other.most_c)
        )

    @property
    def has_default_range(self) -> bool:
        """Tell whether the temperature range is the default range, which ``arctrue load`` does not
        send."""
        span = (self.reference_c - THERMAL_RANGE_K, self.reference_c + THERMAL_RANGE_K)
        return (self.least_c, self.most_c) == tuple(round(limit, 3) for limit in span)

    def change_counts(self, order: int, celsius: float) -> complex:
        """Return the change of cosine (real part) and sine (imaginary part) from T₀ to ``celsius``,
        counts."""
        if order not in self.orders:
            return 0j
        cosine, sine, cosine2, sine2 = self.slopes[self.orders.index(order)] * SLOPE_LSB_COUNTS
        warmth = min(max(celsius, self.least_c), self.most_c) - self.reference_c
        return complex(
            (cosine + cosine2 * warmth) * warmth,
            (sine + sine2 * warmth) * warmth,
        )

    def curve_counts(self, order: int) -> float:
        """Return |c₂| of an order, counts per kelvin squared."""
        if order not in self.orders:
            return 0.0
        return float(np.hypot(*self.slopes[self.orders.index(order)][2:]) * SLOPE_LSB_COUNTS)

    @classmethod
    def from_slopes(
        cls,
        slopes_counts: dict[int, NDArray[np.float64]],
        reference_c: float,
        time_constant_s: float = 0.0,
        range_c: tuple[float, float] = (math.nan, math.nan),
    ) -> ThermalLanes:
        """Return the lanes for slopes ``{order: (4,)}`` in counts per kelvin and per kelvin
        squared. Raises ValueError for a slope that is not finite."""
        values = np.array(list(slopes_counts.values()))
        if not np.all(np.isfinite(values)):
            raise ValueError("slopes: not a finite number")
        words = np.rint(values / SLOPE_LSB_COUNTS)
        return cls(
            tuple(slopes_counts),
            words.astype(np.int64),
            reference_c,
            float(time_constant_s),
            *range_c,
        )


def as_lane(value: complex) -> tuple[float, float]:
    """Return amplitude a and phase φ for which value.real·cos nR + value.imag·sin nR = a·cos(nR +
    φ)."""
    return abs(value), math.atan2(-value.imag, value.real)
